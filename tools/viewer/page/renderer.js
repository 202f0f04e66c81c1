// SPDX-License-Identifier: GPL-3.0-or-later
// Draws pictures of a model with the shaders of blend/, pass by pass as blend/renderer.cpp does: the visible surface,
// the blend of photographs at the middles of pixels, and at silhouettes means over samples, whose surface is drawn
// everywhere here.
import {partOf} from './camera.js';
import {nearbyExposure} from './exposure.js';
import {Glances, MOST_GLANCE_BYTES} from './glances.js';
import {Programs} from './programs.js';
import {Table, bindTexture, makeTexture} from './tables.js';

const CELLS_OF_SHADER = [1, 2, 4];  // kCellsOfShader of blend/zone_mesh.h
const SAMPLED = 4;                  // in the stencil: pixels that are means over samples
const NOTHING = 0xFFFFFFFF;
const BLOCK_BYTES = 192;
const SURFACE_BYTES = 16 + 4;      // a pixel of the visible surface, with its depth
const PICTURE_BYTES = 16 + 8 + 4;  // with depth, stencil, and the picture
const STILL_BYTES = 4;

// Still pictures are drawn in parts of about so many pixels a side: the targets of their samples are then small, and a
// slow GPU gets no task that takes long.
const PART_PX = 320;
const AROUND_PX = 1;  // whether a pixel is at a silhouette its neighbours say

export class Renderer {
  constructor(gl, scene, shaders) {
    Object.assign(this, {gl, scene});
    this.programs = new Programs(gl, shaders, scene.blend.views);
    this.glances = new Glances(this);
    this.targets = new Map();  // by what they are for
    this.block = gl.createBuffer();
    gl.bindBuffer(gl.UNIFORM_BUFFER, this.block);
    gl.bufferData(gl.UNIFORM_BUFFER, BLOCK_BYTES, gl.DYNAMIC_DRAW);
    this.nothing = gl.createVertexArray();
    this.meshBytes = 0;
    this.photographs = null;
  }

  // In place of an earlier one.
  setMesh(mesh) {
    const {gl} = this;
    for (const buffer of this.buffers ?? []) gl.deleteBuffer(buffer);
    if (this.mesh) gl.deleteVertexArray(this.mesh);
    this.buffers = [];
    this.meshBytes = 0;
    this.counts = mesh.counts;
    this.mesh = gl.createVertexArray();
    gl.bindVertexArray(this.mesh);
    const buffer = (target, data) => {
      this.buffers.push(gl.createBuffer());
      gl.bindBuffer(target, this.buffers.at(-1));
      gl.bufferData(target, data, gl.STATIC_DRAW);
      this.meshBytes += data.byteLength;
    };
    buffer(gl.ARRAY_BUFFER, mesh.positions);
    gl.vertexAttribPointer(0, 3, gl.FLOAT, false, 12, 0);
    buffer(gl.ARRAY_BUFFER, mesh.colors);
    gl.vertexAttribPointer(1, 3, gl.UNSIGNED_BYTE, true, 4, 0);
    buffer(gl.ARRAY_BUFFER, mesh.shares);
    gl.vertexAttribPointer(2, 3, gl.UNSIGNED_BYTE, true, 4, 0);
    buffer(gl.ARRAY_BUFFER, mesh.zones);
    gl.vertexAttribIPointer(3, 1, gl.UNSIGNED_INT, 4, 0);
    for (let attribute = 0; attribute < 4; ++attribute) gl.enableVertexAttribArray(attribute);
    buffer(gl.ELEMENT_ARRAY_BUFFER, mesh.corners);
    gl.bindVertexArray(this.nothing);
  }

  // Of each vertex, in place of those that the mesh came with.
  setColors(colors) {
    const {gl} = this;
    gl.bindBuffer(gl.ARRAY_BUFFER, this.buffers[1]);
    gl.bufferSubData(gl.ARRAY_BUFFER, 0, colors);
  }

  setTables(tables) {
    const {gl} = this;
    for (const table of Object.values(this.tables ?? {})) table.release();
    this.tables = {
      zones: new Table(gl, tables.zones, 3),
      cells: new Table(gl, tables.cells, 3),
      references: new Table(gl, tables.references, 1),
    };
  }

  // Whether programs for pictures are compiled; asks for them.
  ready() {
    if (!this.mesh || !this.photographs || !this.tables) return false;
    const needed = [['surface', 0], ['fade', 0], ['glance', 0], ...CELLS_OF_SHADER.filter((_, i) => this.counts[i] > 0).map((n) => ['blend', n])];
    return needed.map(([pass, cells]) => this.programs.ready(pass, cells)).every(Boolean);
  }

  readyForStills() {
    return [['silhouettes', 0], ['samples', 4]].map(([pass, cells]) => this.programs.ready(pass, cells)).every(Boolean);
  }

  // What targets take, bytes, when both a moving and a still picture of such sizes were drawn.
  bytesToDraw(moving, still) {
    const [part, ofMoving, ofStill] = [still.map((side) => Math.min(side, PART_PX + 2 * AROUND_PX)), moving, still]
        .map(([width, height]) => width * height);
    const samples = this.scene.blend.supersample ** 2;
    const ofPart = part * (PICTURE_BYTES + samples * SURFACE_BYTES);
    return MOST_GLANCE_BYTES + PICTURE_BYTES * ofMoving + STILL_BYTES * ofStill + ofPart;
  }

  // Of the mesh, with its references.
  modelBytes() {
    let sum = this.meshBytes;
    for (const table of Object.values(this.tables ?? {})) sum += table.bytes;
    return sum;
  }

  // Bytes on the GPU, as they were asked for.
  bytes() {
    let sum = this.modelBytes() + (this.photographs ? this.photographs.bytes : 0);
    for (const target of this.targets.values()) sum += target.bytes;
    return sum;
  }

  // The most that there ever was at a time; `besides`: what is there now for a moment.
  noteBytes(besides = 0) {
    this.mostBytes = Math.max(this.mostBytes ?? 0, this.bytes() + besides);
  }

  describe(camera, exposure) {
    const {gl, scene} = this;
    const block = new ArrayBuffer(BLOCK_BYTES);
    const floats = new Float32Array(block);
    const numbers = new Int32Array(block);
    const {rotation: r, translation: t} = camera;
    const layout = this.photographs?.layout;
    floats.set([
      r[0], r[1], r[2], t[0], r[3], r[4], r[5], t[1], r[6], r[7], r[8], t[2],
      camera.fx, camera.fy, camera.cx, camera.cy,
      2 * camera.fx / camera.width, -2 * camera.fy / camera.height,
      2 * camera.cx / camera.width - 1, 1 - 2 * camera.cy / camera.height,
      ...[0, 1, 2].map((i) => -(r[i] * t[0] + r[3 + i] * t[1] + r[6 + i] * t[2])), camera.height,
      ...exposure, scene.near_depth,
      scene.blend.lambda, 1 + scene.blend.occlusion_tolerance, 0, 0,
    ]);
    numbers.set([
      scene.blend.printed_position, scene.blend.rims, scene.blend.fade_last, scene.blend.consistent,
      scene.blend.cubic ? scene.cubic_levels : 0, scene.levels, scene.blend.prefilter, 1,
      layout?.tile ?? 1, layout?.tile ?? 1, 0, layout?.slotColumns ?? 1,
      layout?.slotRows ?? 1, scene.blend.supersample, scene.blend.antialias_all, 0,
    ].map(Number), 32);
    gl.bindBuffer(gl.UNIFORM_BUFFER, this.block);
    gl.bufferSubData(gl.UNIFORM_BUFFER, 0, block);
    gl.bindBufferBase(gl.UNIFORM_BUFFER, 0, this.block);
  }

  bindTables() {
    const {gl} = this;
    this.photographs.bind();
    for (const [name, table] of Object.entries(this.tables)) bindTexture(gl, name, gl.TEXTURE_2D, table.texture);
  }

  // Made anew where the size has changed.
  target(use, width, height, make) {
    const known = this.targets.get(use);
    if (known && known.width === width && known.height === height) return known;
    if (known) known.release();
    const target = {width, height, ...make()};
    this.targets.set(use, target);
    this.noteBytes();
    return target;
  }

  // Where the visible surface is drawn to, and, with `picture`, the picture of it.
  surfaceTarget(use, width, height, picture) {
    const {gl} = this;
    return this.target(use, width, height, () => {
      const surface = makeTexture(gl, gl.RGBA32UI, width, height);
      const depth = gl.createRenderbuffer();
      gl.bindRenderbuffer(gl.RENDERBUFFER, depth);
      gl.renderbufferStorage(
          gl.RENDERBUFFER, picture ? gl.DEPTH32F_STENCIL8 : gl.DEPTH_COMPONENT32F, width, height);
      const attachment = picture ? gl.DEPTH_STENCIL_ATTACHMENT : gl.DEPTH_ATTACHMENT;
      const framebuffer = (texture) => {
        const name = gl.createFramebuffer();
        gl.bindFramebuffer(gl.FRAMEBUFFER, name);
        gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, texture, 0);
        gl.framebufferRenderbuffer(gl.FRAMEBUFFER, attachment, gl.RENDERBUFFER, depth);
        return name;
      };
      const colour = picture ? makeTexture(gl, gl.RGBA8, width, height) : null;
      const target = {
        surface, colour, pass: framebuffer(surface), blend: picture ? framebuffer(colour) : null,
        bytes: width * height * (picture ? PICTURE_BYTES : SURFACE_BYTES),
      };
      target.release = () => {
        gl.deleteTexture(surface);
        gl.deleteTexture(colour);
        gl.deleteRenderbuffer(depth);
        gl.deleteFramebuffer(target.pass);
        gl.deleteFramebuffer(target.blend);
      };
      return target;
    });
  }

  // The picture as a whole, put together of its parts.
  stillTarget(width, height) {
    const {gl} = this;
    return this.target('still', width, height, () => {
      const colour = makeTexture(gl, gl.RGBA8, width, height);
      const framebuffer = gl.createFramebuffer();
      gl.bindFramebuffer(gl.FRAMEBUFFER, framebuffer);
      gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, colour, 0);
      return {
        colour, framebuffer, bytes: STILL_BYTES * width * height,
        release: () => {
          gl.deleteTexture(colour);
          gl.deleteFramebuffer(framebuffer);
        },
      };
    });
  }

  setState() {
    const {gl} = this;
    for (const test of [gl.CULL_FACE, gl.BLEND, gl.SCISSOR_TEST, gl.DITHER, gl.STENCIL_TEST, gl.DEPTH_TEST]) {
      gl.disable(test);
    }
    gl.colorMask(true, true, true, true);
    gl.depthMask(true);
    gl.stencilMask(0xFF);
    gl.bindVertexArray(this.nothing);
  }

  drawSurface(target, marks) {
    const {gl} = this;
    gl.bindFramebuffer(gl.FRAMEBUFFER, target.pass);
    gl.viewport(0, 0, target.width, target.height);
    if (target.surface) gl.clearBufferuiv(gl.COLOR, 0, [NOTHING, 0, 0, 0]);
    if (marks) {
      gl.clearBufferfi(gl.DEPTH_STENCIL, 0, 0, 0);
      gl.enable(gl.STENCIL_TEST);
      gl.stencilOp(gl.KEEP, gl.KEEP, gl.REPLACE);
    } else {
      gl.clearBufferfv(gl.DEPTH, 0, [0]);
    }
    gl.enable(gl.DEPTH_TEST);
    gl.depthFunc(gl.GREATER);
    this.programs.use('surface');
    gl.bindVertexArray(this.mesh);
    let first = 0;
    this.counts.forEach((count, i) => {
      if (marks) gl.stencilFunc(gl.ALWAYS, i + 1, 0xFF);
      if (count > 0) gl.drawElements(gl.TRIANGLES, count, gl.UNSIGNED_INT, 4 * first);
      first += count;
    });
    gl.disable(gl.STENCIL_TEST);
    gl.disable(gl.DEPTH_TEST);
    gl.bindVertexArray(this.nothing);
  }

  drawScreen(pass, cells, surface) {
    const {gl} = this;
    bindTexture(gl, 'surfaces', gl.TEXTURE_2D, surface);
    const program = this.programs.use(pass, cells);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    return program;
  }

  drawBlend(target) {
    const {gl} = this;
    gl.bindFramebuffer(gl.FRAMEBUFFER, target.blend);
    gl.viewport(0, 0, target.width, target.height);
    gl.clearBufferfv(gl.COLOR, 0, [0, 0, 0, 0]);
    gl.enable(gl.STENCIL_TEST);
    gl.stencilMask(0);
    CELLS_OF_SHADER.forEach((cells, i) => {
      if (this.counts[i] === 0) return;
      gl.stencilFunc(gl.EQUAL, i + 1, 0xFF);
      this.drawScreen('blend', cells, target.surface);
    });
    gl.stencilMask(0xFF);
    gl.disable(gl.STENCIL_TEST);
  }

  drawSamples(target) {
    const {gl} = this;
    const across = this.scene.blend.supersample;
    const samples = this.surfaceTarget('samples', across * target.width, across * target.height, false);
    this.drawSurface(samples, false);
    gl.bindFramebuffer(gl.FRAMEBUFFER, target.blend);
    gl.viewport(0, 0, target.width, target.height);
    gl.enable(gl.STENCIL_TEST);
    gl.stencilFunc(gl.ALWAYS, SAMPLED, 0xFF);
    gl.stencilOp(gl.KEEP, gl.KEEP, gl.REPLACE);
    gl.colorMask(false, false, false, false);
    this.drawScreen('silhouettes', 0, target.surface);
    gl.colorMask(true, true, true, false);
    gl.stencilFunc(gl.EQUAL, SAMPLED, 0xFF);
    gl.stencilMask(0);
    this.drawScreen('samples', 4, samples.surface);
    gl.colorMask(true, true, true, true);
    gl.stencilMask(0xFF);
    gl.disable(gl.STENCIL_TEST);
  }

  drawFade(target) {
    const {gl} = this;
    gl.bindFramebuffer(gl.FRAMEBUFFER, target.blend);
    gl.viewport(0, 0, target.width, target.height);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
    gl.colorMask(true, true, true, false);
    bindTexture(gl, 'surfaces', gl.TEXTURE_2D, target.surface);
    const program = this.programs.use('fade');
    gl.uniform1f(program.uniform('least_cosine'), this.scene.photographed.cosine);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    gl.colorMask(true, true, true, true);
    gl.disable(gl.BLEND);
  }

  // How deep a stored view's camera sees, reversed as in the surface's pass, in a texture that is good until the next
  // one.
  drawViewDepths(camera) {
    const {gl} = this;
    this.setState();
    this.describe(camera, [1, 1, 1]);
    const {width, height} = camera;
    const target = this.target('view', width, height, () => {
      const depths = makeTexture(gl, gl.DEPTH_COMPONENT32F, width, height);
      const pass = gl.createFramebuffer();
      gl.bindFramebuffer(gl.FRAMEBUFFER, pass);
      gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.TEXTURE_2D, depths, 0);
      gl.drawBuffers([gl.NONE]);
      const release = () => {
        gl.deleteTexture(depths);
        gl.deleteFramebuffer(pass);
      };
      return {depths, pass, release, bytes: 4 * width * height};
    });
    this.drawSurface(target, false);
    return target.depths;
  }

  dropTarget(use) {
    this.targets.get(use)?.release();
    this.targets.delete(use);
  }

  // The middles of pixels alone: for a camera that moves. Returns the target.
  draw(camera) {
    this.setState();
    this.describe(camera, nearbyExposure(this.scene, camera));
    const target = this.surfaceTarget('moving', camera.width, camera.height, true);
    this.drawSurface(target, true);
    if (this.ready()) {
      this.bindTables();
      this.drawBlend(target);
      this.drawFade(target);
    }
    return target;
  }

  // The picture that `lumatlas render` draws, part by part: each call of next() draws one, and the last returns. With
  // `fades`, averaged colours where no photograph was taken from near there.
  *drawStill(camera, fades) {
    const {gl} = this;
    const exposure = nearbyExposure(this.scene, camera);
    const still = this.stillTarget(camera.width, camera.height);
    const [across, down] = [camera.width, camera.height].map((size) => Math.ceil(size / PART_PX));
    const step = [Math.ceil(camera.width / across), Math.ceil(camera.height / down)];
    const size = [Math.min(camera.width, step[0] + 2 * AROUND_PX), Math.min(camera.height, step[1] + 2 * AROUND_PX)];
    for (let i = 0; i < across * down; ++i) {
      const place = [i % across * step[0], Math.floor(i / across) * step[1]];
      // All parts are of one size; those at the picture's border reach farther inwards.
      const [x, y] = place.map((v, axis) =>
          Math.max(0, Math.min(v - AROUND_PX, [camera.width, camera.height][axis] - size[axis])));
      this.setState();
      this.describe(partOf(camera, x, y, ...size), exposure);
      this.bindTables();
      const part = this.surfaceTarget('part', ...size, true);
      this.drawSurface(part, true);
      this.drawBlend(part);
      if (this.scene.blend.supersample > 1) this.drawSamples(part);
      if (fades) this.drawFade(part);
      gl.bindFramebuffer(gl.READ_FRAMEBUFFER, part.blend);
      gl.bindFramebuffer(gl.DRAW_FRAMEBUFFER, still.framebuffer);
      const from = place;
      const to = [Math.min(camera.width, place[0] + step[0]), Math.min(camera.height, place[1] + step[1])];
      const bottom = (v, height) => height - v;
      gl.blitFramebuffer(
          from[0] - x, bottom(to[1] - y, size[1]), to[0] - x, bottom(from[1] - y, size[1]),
          from[0], bottom(to[1], camera.height), to[0], bottom(from[1], camera.height), gl.COLOR_BUFFER_BIT,
          gl.NEAREST);
      yield;
    }
    return still;
  }

  // What a mode shows of the surface that `target` holds, in its colours.
  drawMode(target, mode) {
    const {gl} = this;
    let diagnosis = null;
    if (mode !== 'geometry' && mode !== 'colours') diagnosis = this.diagnose(target);
    gl.bindFramebuffer(gl.FRAMEBUFFER, target.blend);
    gl.viewport(0, 0, target.width, target.height);
    if (diagnosis) bindTexture(gl, 'diagnosis', gl.TEXTURE_2D, diagnosis.packed);
    bindTexture(gl, 'surfaces', gl.TEXTURE_2D, target.surface);
    const program = this.programs.use('modes');
    gl.uniform1i(program.uniform('mode'), ['colours', 'geometry', 'winner', 'weights', 'coverage'].indexOf(mode));
    gl.drawArrays(gl.TRIANGLES, 0, 3);
  }

  diagnose(target) {
    const {gl} = this;
    const diagnosis = this.target('diagnosis', target.width, target.height, () => {
      const packed = makeTexture(gl, gl.RGBA32UI, target.width, target.height);
      const state = makeTexture(gl, gl.RGBA8, target.width, target.height);
      const framebuffer = gl.createFramebuffer();
      gl.bindFramebuffer(gl.FRAMEBUFFER, framebuffer);
      gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, state, 0);
      gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT1, gl.TEXTURE_2D, packed, 0);
      gl.drawBuffers([gl.COLOR_ATTACHMENT0, gl.COLOR_ATTACHMENT1]);
      return {
        packed, framebuffer, bytes: 20 * target.width * target.height,
        release: () => [packed, state].forEach((texture) => gl.deleteTexture(texture)),
      };
    });
    gl.bindFramebuffer(gl.FRAMEBUFFER, diagnosis.framebuffer);
    gl.viewport(0, 0, target.width, target.height);
    gl.clearBufferfv(gl.COLOR, 0, [0, 0, 0, 0]);
    gl.clearBufferuiv(gl.COLOR, 1, [0, NOTHING, 0, 0]);
    this.drawScreen('diagnose', 0, target.surface);
    return diagnosis;
  }

  // A texture of a picture, on the canvas, before a background.
  present(colour, width, height, background) {
    const {gl} = this;
    this.setState();
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.viewport(0, 0, width, height);
    bindTexture(gl, 'image', gl.TEXTURE_2D, colour);
    const program = this.programs.use('present');
    gl.uniform2f(program.uniform('canvas'), width, height);
    gl.uniform3f(program.uniform('above'), ...background.above);
    gl.uniform3f(program.uniform('below'), ...background.below);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
  }

  // How deep the surface is at a pixel of a target, from its top left; 0: there is none.
  depthAt(target, x, y) {
    const {gl} = this;
    const texel = new Uint32Array(4);
    gl.bindFramebuffer(gl.FRAMEBUFFER, target.pass);
    gl.readPixels(Math.floor(x), target.height - 1 - Math.floor(y), 1, 1, gl.RGBA_INTEGER, gl.UNSIGNED_INT, texel);
    return texel[0] === NOTHING ? 0 : new Float32Array(texel.buffer, 4, 1)[0];
  }
}
