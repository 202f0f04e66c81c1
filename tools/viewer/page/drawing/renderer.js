// SPDX-License-Identifier: GPL-3.0-or-later
// Draws pictures of a model with the shaders of blend/, pass by pass as blend/renderer.cpp does: the visible surface,
// the blend of photographs at the middles of pixels, at silhouettes means over samples, whose surface is drawn
// everywhere here, and the blur across depth edges.
import {partOf} from '../camera.js';
import {nearbyExposure} from './exposure.js';
import {Glances, MOST_GLANCE_BYTES} from './glances.js';
import {GlObjects, Targets} from './gl_objects.js';
import {Programs} from './programs.js';
import {Surface} from './surface.js';
import {Surroundings, surroundingsBytes} from './surroundings.js';
import {CELLS_OF_SHADER} from '../reading/surface.js';
import {bindTexture, makeTexture} from './tables.js';
/** @import {Photographs} from './photographs.js' */
/** @import {PictureTarget, Sized, SurfaceTarget} from './gl_objects.js' */
/** @import {Picture} from './surroundings.js' */
/** @import {SurfacePiece} from './surface_piece.js' */
/** @import {Background, Camera, Mode, Scene, Shaders, Size, Vector} from '../types.d.ts' */

const SAMPLED = 4;                  // in the stencil: pixels that are means over samples
// A draft draws all of at most this number of faces. Where there are more, a cell has many, and clusters are small
// beside it. With this number of faces a pixel, clusters are some pixels wide.
const MANY_FACES = 150000;
const FACES_A_PIXEL = 4;
const NOTHING = 0xFFFFFFFF;
const BLOCK_BYTES = 192;
const NEAR_DEPTH_AT = 108;         // bytes into the block
const MOST_OF_MEDIAN = 2;          // of a deviation, that counts at depth edges: see blend/soft_edges.h
const BEHIND = 1 / 64;             // of its depth, by which a coarse surface is drawn behind a fine one
const SURFACE_BYTES = 16 + 4;      // a pixel of the visible surface, with its depth
export const PICTURE_BYTES = 16 + 8 + 4;  // with depth, stencil, and the picture
const EDGE_BYTES = 4;              // a pixel of variances of edges
const STILL_BYTES = 4;
const DIAGNOSIS_BYTES = 16 + 4;

// Longest side of the parts that pictures with samples are drawn in: their targets are then small.
export const MOST_PART_PX = 320;
// A pixel may mix those five pixels away, silhouettes among them are found from their neighbours, and surfaces are
// continued over four: see blend/soft_edges.h and outlines.h.
const AROUND_PX = 10;

// A part of a picture: what is drawn, from its top left corner, and what of that is copied: left, top, right, bottom.
/** @typedef {{x: number, y: number, size: Size, inner: [number, number, number, number]}} Part */

// Parts that cover a camera's picture, those in its middle first. All are of one size, with AROUND_PX pixels around
// what is copied; those at the picture's border reach farther inwards.
/** @param {Camera} camera @param {number} partPx @returns {Part[]} */
export function partsOf({width, height}, partPx) {
  const [across, down] = [width, height].map((side) => Math.ceil(side / partPx));
  const [stepX, stepY] = [Math.ceil(width / across), Math.ceil(height / down)];
  /** @type {Size} */
  const size = [Math.min(width, stepX + 2 * AROUND_PX), Math.min(height, stepY + 2 * AROUND_PX)];
  const start = (/** @type {number} */ at, /** @type {number} */ side, /** @type {number} */ whole) =>
      Math.max(0, Math.min(at - AROUND_PX, whole - side));
  /** @type {Part[]} */
  const parts = [];
  for (let top = 0; top < height; top += stepY) {
    for (let left = 0; left < width; left += stepX) {
      parts.push({
        x: start(left, size[0], width), y: start(top, size[1], height), size,
        inner: [left, top, Math.min(width, left + stepX), Math.min(height, top + stepY)],
      });
    }
  }
  const far = (/** @type {Part} */ {inner: [left, top, right, bottom]}) =>
      Math.hypot(left + right - width, top + bottom - height);
  return parts.sort((a, b) => far(a) - far(b));
}

export class Renderer {
  /** @param {WebGL2RenderingContext} gl @param {Scene} scene @param {Shaders} shaders */
  constructor(gl, scene, shaders) {
    this.gl = gl;
    this.scene = scene;
    this.programs = new Programs(gl, shaders, scene.blend.views);
    this.glances = new Glances(this);
    this.surroundings = new Surroundings(this);
    this.targets = new Targets(gl, () => this.noteBytes());
    this.objects = new GlObjects(gl);
    this.surface = new Surface(gl);
    this.block = this.objects.buffer();
    gl.bindBuffer(gl.UNIFORM_BUFFER, this.block);
    gl.bufferData(gl.UNIFORM_BUFFER, BLOCK_BYTES, gl.DYNAMIC_DRAW);
    this.nothing = this.objects.vertexArray();
    /** @type {Photographs | null} */
    this.photographs = null;
    this.mostBytes = 0;
    this.manyFaces = MANY_FACES;
    this.hasPrepared = false;  // draw() made something for the pictures that follow
    /** @type {Camera | null} */
    this.camera = null;  // that describe() was told of
  }

  release() {
    this.photographs?.release();
    for (const owner of [this.programs, this.targets, this.surface, this.objects]) owner.release();
  }

  // Returns whether the programs for pictures are compiled; starts compiling them.
  ready() {
    if (!this.photographs || !this.surface.hasTables()) return false;
    const drawn = CELLS_OF_SHADER.filter((_, i) => this.isDrawn(i));
    const blends = drawn.map((cells) => this.programs.ready('blend', cells));
    return [...['surface', 'fade', 'glance'].map((pass) => this.programs.ready(pass)), ...blends].every(Boolean);
  }

  // Returns whether the program for drafts is compiled; starts compiling it.
  readyForDrafts() {
    return this.programs.ready('draft', 1);
  }

  // Returns whether there are faces that CELLS_OF_SHADER[i] cells share.
  /** @param {number} i */
  isDrawn(i) {
    return this.surface.has(i) || (i === 0 && this.surface.has(CELLS_OF_SHADER.length));
  }

  readyForStills() {
    const softens = this.softens() ? ['edges', 'edge_rows', 'soft_edges'] : [];
    const outlines = this.continuesOutlines() ? ['outline_rows', 'outlines'] : [];
    return [this.programs.ready('samples', 4), !outlines.length || this.programs.ready('blend', 4),
            ...['silhouettes', ...outlines, ...softens].map((pass) => this.programs.ready(pass))].every(Boolean);
  }

  // Returns whether still frames are blurred across depth edges.
  softens() {
    return this.scene.blend.soft_edges && this.scene.median_deviation > 0;
  }

  // Returns whether still frames continue surfaces past their outlines.
  continuesOutlines() {
    return this.scene.blend.outlines && this.scene.median_deviation > 0;
  }

  // Returns the bytes of render targets for an interactive and a still frame of these sizes.
  /** @param {Size} moving @param {Size} still */
  bytesToDraw(moving, still) {
    const part = [still[0], still[1]].map((side) => Math.min(side, MOST_PART_PX + 2 * AROUND_PX));
    const [ofPart, ofMoving, ofStill] = [part, moving, still].map(([width, height]) => width * height);
    const samples = this.scene.blend.supersample ** 2;
    const ofSurroundings = Math.max(surroundingsBytes(moving), surroundingsBytes(still));
    return MOST_GLANCE_BYTES + ofSurroundings + PICTURE_BYTES * ofMoving + STILL_BYTES * ofStill +
        ofPart * (PICTURE_BYTES + samples * SURFACE_BYTES + STILL_BYTES +
                  (this.softens() ? 2 * EDGE_BYTES : this.continuesOutlines() ? EDGE_BYTES : 0));
  }

  // Bytes on the GPU, as they were asked for.
  bytes() {
    return this.surface.bytes() + (this.photographs?.bytes ?? 0) + this.targets.bytes();
  }

  // The most that there ever was at a time; `besides`: what is there now for a moment.
  noteBytes(besides = 0) {
    this.mostBytes = Math.max(this.mostBytes, this.bytes() + besides);
  }

  /** @param {Camera} camera @param {Vector} exposure */
  describe(camera, exposure) {
    this.camera = camera;
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
      scene.blend.lambda, 1 + scene.blend.occlusion_tolerance, scene.blend.frame_fade, scene.depth_before_far,
    ]);
    numbers.set([
      scene.blend.printed_position, scene.blend.rims, scene.blend.fade_last, scene.blend.consistent,
      scene.blend.cubic ? scene.cubic_levels : 0, scene.levels, scene.blend.prefilter, 1,
      layout?.tile ?? 1, layout?.tile ?? 1, 0, layout?.slotColumns ?? 1,
      layout?.slotRows ?? 1, scene.blend.supersample, scene.blend.antialias_all, scene.blend.soften,
    ].map(Number), 32);
    gl.bindBuffer(gl.UNIFORM_BUFFER, this.block);
    gl.bufferSubData(gl.UNIFORM_BUFFER, 0, block);
    gl.bindBufferBase(gl.UNIFORM_BUFFER, 0, this.block);
  }

  // Replaces the nearest depth, whose share of a face's depth is compared in the depth test.
  /** @param {number} depth */
  setNearDepth(depth) {
    const {gl} = this;
    gl.bindBuffer(gl.UNIFORM_BUFFER, this.block);
    gl.bufferSubData(gl.UNIFORM_BUFFER, NEAR_DEPTH_AT, new Float32Array([depth]));
  }

  bindTables() {
    this.photographs?.bind();
    this.surface.bindTables();
  }

  // Returns the render target of the visible surface.
  /**
   * @param {string} use
   * @param {number} width
   * @param {number} height
   * @returns {SurfaceTarget & {surface: WebGLTexture}}
   */
  surfaceTarget(use, width, height) {
    const {gl} = this;
    return this.targets.of(use, width, height, SURFACE_BYTES, (objects) => {
      const surface = makeTexture(objects, gl.RGBA32UI, width, height);
      const depth = this.depthBuffer(objects, gl.DEPTH_COMPONENT32F, width, height);
      return {surface, pass: this.withDepth(objects, surface, gl.DEPTH_ATTACHMENT, depth)};
    });
  }

  // The same, with the picture of the surface.
  /** @param {string} use @param {number} width @param {number} height @returns {PictureTarget} */
  pictureTarget(use, width, height) {
    const {gl} = this;
    return this.targets.of(use, width, height, PICTURE_BYTES, (objects) => {
      const surface = makeTexture(objects, gl.RGBA32UI, width, height);
      const colour = makeTexture(objects, gl.RGBA8, width, height);
      const depth = this.depthBuffer(objects, gl.DEPTH32F_STENCIL8, width, height);
      return {
        surface, colour, pass: this.withDepth(objects, surface, gl.DEPTH_STENCIL_ATTACHMENT, depth),
        blend: this.withDepth(objects, colour, gl.DEPTH_STENCIL_ATTACHMENT, depth),
      };
    });
  }

  /** @param {GlObjects} objects @param {number} format @param {number} width @param {number} height */
  depthBuffer(objects, format, width, height) {
    const {gl} = this;
    const depth = objects.renderbuffer();
    gl.bindRenderbuffer(gl.RENDERBUFFER, depth);
    gl.renderbufferStorage(gl.RENDERBUFFER, format, width, height);
    return depth;
  }

  /**
   * @param {GlObjects} objects
   * @param {WebGLTexture} colour
   * @param {number} attachment
   * @param {WebGLRenderbuffer} depth
   */
  withDepth(objects, colour, attachment, depth) {
    const {gl} = this;
    const framebuffer = objects.framebuffer(colour);
    gl.framebufferRenderbuffer(gl.FRAMEBUFFER, attachment, gl.RENDERBUFFER, depth);
    return framebuffer;
  }

  // The render target of variances of edges.
  /** @param {string} use @param {number} width @param {number} height */
  edgeTarget(use, width, height) {
    const {gl} = this;
    return this.targets.of(use, width, height, EDGE_BYTES, (objects) => {
      const variances = makeTexture(objects, gl.R32UI, width, height);
      return {variances, framebuffer: objects.framebuffer(variances)};
    });
  }

  // The picture as a whole, put together of its parts.
  /** @param {number} width @param {number} height */
  stillTarget(width, height) {
    return this.targets.of('still', width, height, STILL_BYTES, (objects) => {
      const colour = makeTexture(objects, this.gl.RGBA8, width, height);
      return {colour, framebuffer: objects.framebuffer(colour)};
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

  // `marks`: the stencil says how many cells are blended. `whole`: with the hidden part.
  /** @param {SurfaceTarget} target @param {boolean} marks */
  drawSurface(target, marks, whole = false) {
    const {camera} = this;
    if (!camera) return;
    this.beginSurface(target, marks);
    this.drawPieces(this.surface.seenBy(camera), marks, whole);
    this.endSurface();
  }

  // Draws a draft's surface. Where more than `manyFaces` faces are seen, and FACES_A_PIXEL for each pixel, its pieces
  // are drawn with fewer, which are made for one piece a picture. Returns whether that was done for this one.
  /** @param {PictureTarget} target */
  drawDraftSurface(target) {
    const {camera} = this;
    if (!camera) return false;
    const seen = this.surface.seenBy(camera);
    const faces = seen.reduce((sum, piece) => sum + piece.faces(), 0);
    const most = Math.max(this.manyFaces, FACES_A_PIXEL * target.width * target.height);
    const dense = faces > most ? seen.filter((piece) => piece.isWhole) : [];
    const next = dense.find((piece) => !piece.clustered);
    next?.makeClustered();
    if (next) this.noteBytes();
    const fewer = new Set(dense.filter((piece) => piece.clustered));
    this.beginSurface(target, true);
    this.drawPieces(seen.filter((piece) => !fewer.has(piece)), true, false);
    const program = this.programs.use('surface');
    this.gl.uniform1ui(program.uniform('variant'), 0);
    this.gl.stencilFunc(this.gl.ALWAYS, 1, 0xFF);
    for (const piece of fewer) piece.drawClustered(program.uniform('first_zone'));
    this.endSurface();
    return Boolean(next);
  }

  /** @param {SurfaceTarget} target @param {boolean} marks */
  beginSurface(target, marks) {
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
    const clips = this.programs.clipControl;
    clips?.clipControlEXT(clips.LOWER_LEFT_EXT, clips.ZERO_TO_ONE_EXT);
  }

  /** @param {SurfacePiece[]} pieces @param {boolean} marks @param {boolean} whole */
  drawPieces(pieces, marks, whole) {
    const {gl} = this;
    const program = this.programs.use('surface');
    const [firstZone, variant] = [program.uniform('first_zone'), program.uniform('variant')];
    CELLS_OF_SHADER.forEach((_, group) => {
      if (marks) gl.stencilFunc(gl.ALWAYS, group + 1, 0xFF);
      gl.uniform1ui(variant, group);
      for (const piece of pieces) piece.draw(group, whole, firstZone);
    });
    if (this.surface.has(CELLS_OF_SHADER.length)) {
      if (marks) gl.stencilFunc(gl.ALWAYS, 1, 0xFF);
      gl.uniform1ui(variant, 0);
      this.setNearDepth(this.scene.near_depth * (1 - BEHIND));
      for (const piece of pieces) piece.draw(CELLS_OF_SHADER.length, whole, firstZone);
      this.setNearDepth(this.scene.near_depth);
    }
  }

  endSurface() {
    const {gl} = this;
    const clips = this.programs.clipControl;
    clips?.clipControlEXT(clips.LOWER_LEFT_EXT, clips.NEGATIVE_ONE_TO_ONE_EXT);
    gl.disable(gl.STENCIL_TEST);
    gl.disable(gl.DEPTH_TEST);
    gl.bindVertexArray(this.nothing);
  }

  /** @param {string} pass @param {number} cells @param {WebGLTexture} surface */
  drawScreen(pass, cells, surface) {
    const {gl} = this;
    bindTexture(gl, 'surfaces', gl.TEXTURE_2D, surface);
    const program = this.programs.use(pass, cells);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    return program;
  }

  // In a draft, the cells of a zone count as one, and photographs are sampled linearly. `isContinued`: the surface may
  // be, past outlines.
  /** @param {PictureTarget} target */
  drawBlend(target, isDraft = false, isContinued = false) {
    const {gl} = this;
    gl.bindFramebuffer(gl.FRAMEBUFFER, target.blend);
    gl.viewport(0, 0, target.width, target.height);
    gl.clearBufferfv(gl.COLOR, 0, [0, 0, 0, 0]);
    gl.enable(gl.STENCIL_TEST);
    gl.stencilMask(0);
    if (isDraft) {
      gl.stencilFunc(gl.NOTEQUAL, 0, 0xFF);
      this.drawScreen('draft', 1, target.surface);
    } else {
      CELLS_OF_SHADER.forEach((cells, i) => {
        if (!this.isDrawn(i) && !(isContinued && i === CELLS_OF_SHADER.length - 1)) return;
        gl.stencilFunc(gl.EQUAL, i + 1, 0xFF);
        this.drawScreen('blend', cells, target.surface);
      });
    }
    gl.stencilMask(0xFF);
    gl.disable(gl.STENCIL_TEST);
  }

  /** @param {PictureTarget} target */
  drawSamples(target) {
    const {gl} = this;
    const across = this.scene.blend.supersample;
    const samples = this.surfaceTarget('samples', across * target.width, across * target.height);
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
    bindTexture(gl, 'middles', gl.TEXTURE_2D, target.surface);
    bindTexture(gl, 'middle_colors', gl.TEXTURE_2D, this.copyOf(target));
    gl.bindFramebuffer(gl.FRAMEBUFFER, target.blend);
    this.drawScreen('samples', 4, samples.surface);
    gl.colorMask(true, true, true, true);
    gl.stencilMask(0xFF);
    gl.disable(gl.STENCIL_TEST);
  }

  // Returns a copy of the picture as it is now, for a pass that changes it.
  /** @param {PictureTarget} target */
  copyOf(target) {
    const {gl} = this;
    const {width, height} = target;
    const copy = this.targets.of('copy', width, height, STILL_BYTES, (objects) => {
      const colour = makeTexture(objects, gl.RGBA8, width, height);
      return {colour, framebuffer: objects.framebuffer(colour)};
    });
    gl.bindFramebuffer(gl.READ_FRAMEBUFFER, target.blend);
    gl.bindFramebuffer(gl.DRAW_FRAMEBUFFER, copy.framebuffer);
    gl.blitFramebuffer(0, 0, width, height, 0, 0, width, height, gl.COLOR_BUFFER_BIT, gl.NEAREST);
    return copy.colour;
  }

  // Continues the middles' surface past outlines. Pixels that it comes to are for the shader of the most cells, which
  // draws all. The target of the samples, which are drawn later, has the surface as it was, in its lower left corner.
  /** @param {PictureTarget} target */
  continueOutlines(target) {
    const {gl} = this;
    const {width, height} = target;
    const across = this.scene.blend.supersample;
    const copy = this.surfaceTarget('samples', across * width, across * height);
    const rows = this.edgeTarget('edge rows', width, height);
    gl.viewport(0, 0, width, height);
    gl.bindFramebuffer(gl.READ_FRAMEBUFFER, target.pass);
    gl.bindFramebuffer(gl.DRAW_FRAMEBUFFER, copy.pass);
    gl.blitFramebuffer(0, 0, width, height, 0, 0, width, height, gl.COLOR_BUFFER_BIT, gl.NEAREST);
    gl.bindFramebuffer(gl.FRAMEBUFFER, rows.framebuffer);
    this.drawScreen('outline_rows', 0, target.surface);
    gl.bindFramebuffer(gl.FRAMEBUFFER, target.pass);
    gl.enable(gl.STENCIL_TEST);
    gl.stencilFunc(gl.ALWAYS, CELLS_OF_SHADER.length, 0xFF);
    gl.stencilOp(gl.KEEP, gl.KEEP, gl.REPLACE);
    bindTexture(gl, 'row_depths', gl.TEXTURE_2D, rows.variances);
    const most = this.programs.use('outlines').uniform('most_deviation');
    gl.uniform1f(most, MOST_OF_MEDIAN * this.scene.median_deviation);
    this.drawScreen('outlines', 0, copy.surface);
    gl.disable(gl.STENCIL_TEST);
  }

  // Blurs the picture across depth edges, as the middles' surface tells.
  /** @param {PictureTarget} target */
  softenEdges(target) {
    const {gl} = this;
    const {width, height} = target;
    const edges = this.edgeTarget('edges', width, height);
    const rows = this.edgeTarget('edge rows', width, height);
    gl.viewport(0, 0, width, height);
    gl.bindFramebuffer(gl.FRAMEBUFFER, edges.framebuffer);
    gl.clearBufferuiv(gl.COLOR, 0, [0, 0, 0, 0]);
    const most = this.programs.use('edges').uniform('most_deviation');
    gl.uniform1f(most, MOST_OF_MEDIAN * this.scene.median_deviation);
    this.drawScreen('edges', 0, target.surface);
    gl.bindFramebuffer(gl.FRAMEBUFFER, rows.framebuffer);
    gl.clearBufferuiv(gl.COLOR, 0, [0, 0, 0, 0]);
    bindTexture(gl, 'variances', gl.TEXTURE_2D, edges.variances);
    this.drawScreen('edge_rows', 0, target.surface);
    bindTexture(gl, 'sharp', gl.TEXTURE_2D, this.copyOf(target));
    gl.bindFramebuffer(gl.FRAMEBUFFER, target.blend);
    bindTexture(gl, 'variances', gl.TEXTURE_2D, rows.variances);
    gl.colorMask(true, true, true, false);
    this.drawScreen('soft_edges', 0, target.surface);
    gl.colorMask(true, true, true, true);
  }

  /** @param {PictureTarget} target */
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

  // Draws the depths that a stored view's camera sees, reversed as in the surface's pass, in a texture that is good
  // until the next one.
  /** @param {Camera} camera */
  drawViewDepths(camera) {
    const {gl} = this;
    this.setState();
    this.describe(camera, [1, 1, 1]);
    const {width, height} = camera;
    const target = this.targets.of('view', width, height, 4, (objects) => {
      const depths = makeTexture(objects, gl.DEPTH_COMPONENT32F, width, height);
      const pass = objects.framebuffer();
      gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.TEXTURE_2D, depths, 0);
      gl.drawBuffers([gl.NONE]);
      return {depths, pass};
    });
    this.drawSurface(target, false, true);
    return target.depths;
  }

  // The middles of pixels alone: for a camera that moves. Returns the target.
  /** @param {Camera} camera */
  draw(camera, isDraft = false) {
    this.setState();
    this.describe(camera, nearbyExposure(this.scene, camera));
    const target = this.pictureTarget('moving', camera.width, camera.height);
    this.hasPrepared = isDraft && this.drawDraftSurface(target);
    if (!isDraft) this.drawSurface(target, true);
    if (this.ready()) {
      this.bindTables();
      this.surface.rank(camera, this.scene);
      this.drawBlend(target, isDraft);
      this.drawFade(target);
    }
    return target;
  }

  // The picture that `lumatlas render` draws, part by part: each call of next() draws one and says how many pixels it
  // has, and the last returns. `fades`: averaged colours where no photograph was taken from near there.
  /** @param {Camera} camera @param {boolean} fades */
  *drawStill(camera, fades) {
    const exposure = nearbyExposure(this.scene, camera);
    const still = this.stillTarget(camera.width, camera.height);
    for (const part of partsOf(camera, MOST_PART_PX)) {
      const {x, y, size} = part;
      this.setState();
      const shown = partOf(camera, x, y, ...size);
      this.describe(shown, exposure);
      this.bindTables();
      this.surface.rank(shown, this.scene);
      const target = this.pictureTarget('part', ...size);
      this.drawSurface(target, true);
      if (this.continuesOutlines()) this.continueOutlines(target);
      this.drawBlend(target, false, this.continuesOutlines());
      if (this.scene.blend.supersample > 1) this.drawSamples(target);
      if (this.softens()) this.softenEdges(target);
      if (fades) this.drawFade(target);
      this.copyPart(target, part, still);
      yield size[0] * size[1];
    }
    return still;
  }

  // The surface that the camera sees, for blendPart(), and what is seen where no part is drawn yet.
  /** @param {Camera} camera @param {PictureTarget | null} under */
  beginParts(camera, under) {
    const still = this.stillTarget(camera.width, camera.height);
    if (under) this.copyWhole(under, still);
    this.setState();
    this.describe(camera, [1, 1, 1]);
    const target = this.pictureTarget('moving', camera.width, camera.height);
    this.drawSurface(target, true);
    return target;
  }

  // A part of the picture of a surface that beginParts() drew, into the still frame: the middles of pixels alone.
  /** @param {PictureTarget} target @param {Camera} camera @param {Part} part */
  blendPart(target, camera, {inner: [left, top, right, bottom]}) {
    const {gl} = this;
    this.setState();
    this.describe(camera, nearbyExposure(this.scene, camera));
    this.bindTables();
    this.surface.rank(camera, this.scene);
    gl.enable(gl.SCISSOR_TEST);
    gl.scissor(left, target.height - bottom, right - left, bottom - top);
    this.drawBlend(target);
    this.drawFade(target);
    gl.disable(gl.SCISSOR_TEST);
    const {width, height} = camera;
    this.copyPart(target, {x: 0, y: 0, size: [width, height], inner: [left, top, right, bottom]},
                  this.stillTarget(width, height));
  }

  // A part into the picture, without what is around it.
  /** @param {PictureTarget} from @param {Part} part @param {Sized & {framebuffer: WebGLFramebuffer}} still */
  copyPart(from, {x, y, size, inner}, still) {
    const {gl} = this;
    const [left, top, right, bottom] = inner;
    gl.bindFramebuffer(gl.READ_FRAMEBUFFER, from.blend);
    gl.bindFramebuffer(gl.DRAW_FRAMEBUFFER, still.framebuffer);
    gl.blitFramebuffer(
        left - x, size[1] - (bottom - y), right - x, size[1] - (top - y),
        left, still.height - bottom, right, still.height - top, gl.COLOR_BUFFER_BIT, gl.NEAREST);
  }

  // A picture into another one, whatever their sizes.
  /** @param {PictureTarget} from @param {Sized & {framebuffer: WebGLFramebuffer}} still */
  copyWhole(from, still) {
    const {gl} = this;
    gl.bindFramebuffer(gl.READ_FRAMEBUFFER, from.blend);
    gl.bindFramebuffer(gl.DRAW_FRAMEBUFFER, still.framebuffer);
    gl.blitFramebuffer(
        0, 0, from.width, from.height, 0, 0, still.width, still.height, gl.COLOR_BUFFER_BIT, gl.LINEAR);
  }

  // Draws the surface in `target` in the colours of a mode.
  /** @param {PictureTarget} target @param {Mode} mode */
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

  /** @param {PictureTarget} target */
  diagnose(target) {
    const {gl} = this;
    const diagnosis = this.targets.of('diagnosis', target.width, target.height, DIAGNOSIS_BYTES, (objects) => {
      const state = makeTexture(objects, gl.RGBA8, target.width, target.height);
      const packed = makeTexture(objects, gl.RGBA32UI, target.width, target.height);
      return {packed, framebuffer: objects.framebuffer(state, packed)};
    });
    gl.bindFramebuffer(gl.FRAMEBUFFER, diagnosis.framebuffer);
    gl.viewport(0, 0, target.width, target.height);
    gl.clearBufferfv(gl.COLOR, 0, [0, 0, 0, 0]);
    gl.clearBufferuiv(gl.COLOR, 1, [0, NOTHING, 0, 0]);
    this.drawScreen('diagnose', 0, target.surface);
    return diagnosis;
  }

  // A picture on the canvas, of that many pixels, before a background.
  /** @param {Picture} picture @param {number} width @param {number} height @param {Background} background */
  present(picture, width, height, background) {
    this.presentIn(null, {x: 0, y: 0, width, height}, picture, background);
  }

  // The same in a part of a framebuffer, pixels from its bottom left corner; null: the canvas.
  /**
   * @param {WebGLFramebuffer | null} framebuffer
   * @param {{x: number, y: number, width: number, height: number}} place
   * @param {Picture} picture
   * @param {Background} background
   */
  presentIn(framebuffer, {x, y, width, height}, picture, {above, below, continues}) {
    const {gl} = this;
    this.setState();
    const around = continues ? this.surroundings.of(picture) : null;
    if (around) bindTexture(gl, 'fine', gl.TEXTURE_2D, around.cells);
    gl.bindFramebuffer(gl.FRAMEBUFFER, framebuffer);
    gl.viewport(x, y, width, height);
    bindTexture(gl, 'image', gl.TEXTURE_2D, picture.colour);
    const program = this.programs.use('present');
    gl.uniform4f(program.uniform('place'), x, y, width, height);
    gl.uniform3fv(program.uniform('above'), above);
    gl.uniform3fv(program.uniform('below'), below);
    gl.uniform1i(program.uniform('continues'), Number(continues));
    gl.uniform2fv(program.uniform('cells_across'), around?.across ?? [1, 1]);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
  }

  // Returns the depth of the surface at a pixel of a target, from its top left; 0: there is none.
  /** @param {SurfaceTarget} target @param {number} x @param {number} y */
  depthAt(target, x, y) {
    return this.readSurface(target, Math.floor(x), Math.floor(y), 1, 1)[0].depth;
  }

  // The depths at a pixel and at its neighbours.
  /** @param {SurfaceTarget} target @param {number} x @param {number} y */
  depthsAround(target, x, y) {
    const [left, top] = [Math.max(0, Math.floor(x) - 1), Math.max(0, Math.floor(y) - 1)];
    const [right, bottom] = [Math.min(target.width, Math.floor(x) + 2), Math.min(target.height, Math.floor(y) + 2)];
    return this.readSurface(target, left, top, right - left, bottom - top).map(({depth}) => depth);
  }

  // Returns depth and zone of the surface that a camera of one pixel sees; depth 0: there is none.
  /** @param {Camera} camera */
  surfaceOfPixel(camera) {
    this.setState();
    this.describe(camera, [1, 1, 1]);
    const target = this.surfaceTarget('pixel', 1, 1);
    this.drawSurface(target, false);
    return this.readSurface(target, 0, 0, 1, 1)[0];
  }

  /**
   * @param {SurfaceTarget} target
   * @param {number} left
   * @param {number} top
   * @param {number} width
   * @param {number} height
   */
  readSurface(target, left, top, width, height) {
    const {gl} = this;
    const texels = new Uint32Array(4 * width * height);
    gl.bindFramebuffer(gl.FRAMEBUFFER, target.pass);
    gl.readPixels(left, target.height - top - height, width, height, gl.RGBA_INTEGER, gl.UNSIGNED_INT, texels);
    const depths = new Float32Array(texels.buffer);
    return Array.from({length: width * height}, (_, i) => {
      const zone = texels[4 * i];
      return {zone, depth: zone === NOTHING ? 0 : depths[4 * i + 1]};
    });
  }
}
