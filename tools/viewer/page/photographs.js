// SPDX-License-Identifier: GPL-3.0-or-later
// The photographs on the GPU. A view comes as a picture and a mask; its depths are drawn from the mesh when it comes.
import {scaledCamera} from './camera.js';
import {DEPTH_BLOCK_SIDE, samePlaces, slotOfTile} from './layout.js';
import {loadMask} from './model.js';
import {NO_SLOT, SPARE_UNIT, Table, bindTexture, depthScale, makeTexture, viewTable} from './tables.js';

export class Photographs {
  // `resident`: for each tile of the scene, 1 or 0.
  constructor(gl, programs, scene, layout, resident) {
    Object.assign(this, {gl, programs, scene, layout, resident});
    this.slots = new Uint32Array(layout.tiles).fill(NO_SLOT);
    this.tileSlots = new Table(gl, this.slots, 1);
    this.views = new Table(gl, viewTable(scene, layout), 4);
    this.colours = this.array(gl.SRGB8_ALPHA8, layout.size, scene.levels, gl.LINEAR);
    this.depths = this.array(gl.RGBA32UI, layout.size.map((side) => side / DEPTH_BLOCK_SIDE), 1, gl.NEAREST);
    this.bytes = layout.bytes + this.tileSlots.bytes + this.views.bytes;
    this.there = new Set();
    this.framebuffer = gl.createFramebuffer();
  }

  array(format, size, levels, filter) {
    const {gl, layout} = this;
    const texture = gl.createTexture();
    gl.activeTexture(gl.TEXTURE0 + SPARE_UNIT);
    gl.bindTexture(gl.TEXTURE_2D_ARRAY, texture);
    gl.texStorage3D(gl.TEXTURE_2D_ARRAY, levels, format, ...size, layout.pages);
    const between = levels > 1 ? gl.LINEAR_MIPMAP_LINEAR : filter;
    gl.texParameteri(gl.TEXTURE_2D_ARRAY, gl.TEXTURE_MIN_FILTER, between);
    gl.texParameteri(gl.TEXTURE_2D_ARRAY, gl.TEXTURE_MAG_FILTER, filter);
    gl.texParameteri(gl.TEXTURE_2D_ARRAY, gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE);
    gl.texParameteri(gl.TEXTURE_2D_ARRAY, gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE);
    return texture;
  }

  bind() {
    const {gl} = this;
    bindTexture(gl, 'photographs', gl.TEXTURE_2D_ARRAY, this.colours);
    bindTexture(gl, 'depths', gl.TEXTURE_2D_ARRAY, this.depths);
    bindTexture(gl, 'views', gl.TEXTURE_2D, this.views.texture);
    bindTexture(gl, 'tile_slots', gl.TEXTURE_2D, this.tileSlots.texture);
  }

  // What store() needs of a view, over the network.
  static async fetched(files, scene, slot) {
    const view = scene.views[slot];
    const plain = {premultiplyAlpha: 'none', colorSpaceConversion: 'none', imageOrientation: 'none'};
    const [picture, mask] = await Promise.all([
      files.blob(view.photograph).then((blob) => createImageBitmap(blob, plain)),
      loadMask(files, view),
    ]);
    return {slot, picture, mask};
  }

  // `renderer` draws the depths. Promises how much of what the view shows was photographed (kept_path.h).
  store({slot, picture, mask}, renderer) {
    const {gl} = this;
    const view = this.scene.views[slot];
    const image = makeTexture(gl, gl.RGBA8, picture.width, picture.height);
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
    gl.pixelStorei(gl.UNPACK_PREMULTIPLY_ALPHA_WEBGL, false);
    gl.pixelStorei(gl.UNPACK_COLORSPACE_CONVERSION_WEBGL, gl.NONE);
    gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, gl.RGBA, gl.UNSIGNED_BYTE, picture);
    const valid = makeTexture(gl, gl.RG8UI, picture.width, picture.height);
    gl.texSubImage2D(
        gl.TEXTURE_2D, 0, 0, 0, picture.width, picture.height, gl.RG_INTEGER, gl.UNSIGNED_BYTE, mask);
    bindTexture(gl, 'image', gl.TEXTURE_2D, image);
    bindTexture(gl, 'mask', gl.TEXTURE_2D, valid);
    renderer.setState();
    this.drawLevels(this.layout.places[slot]);
    const camera = scaledCamera(view, this.layout.scale);
    const target = this.drawDepths(this.layout.places[slot], view, camera, renderer);
    gl.deleteTexture(image);
    gl.deleteTexture(valid);
    picture.close();
    this.show(slot);
    return renderer.photographedShare(target, camera, camera.width / camera.height);
  }

  // Means over what a texel covers, in the page and at each of its coarser levels.
  drawLevels(place) {
    const {gl, layout, scene} = this;
    const program = this.programs.use('photograph');
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.framebuffer);
    for (let level = 0; level < scene.levels; ++level) {
      gl.framebufferTextureLayer(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, this.colours, level, place.page);
      const [x, y, width, height] = [place.x, place.y, ...layout.cell].map((v) => v >> level);
      gl.viewport(x, y, width, height);
      gl.uniform2i(program.uniform('origin'), x, y);
      gl.uniform1f(program.uniform('pixels'), 2 ** level / layout.scale);
      gl.drawArrays(gl.TRIANGLES, 0, 3);
    }
  }

  // The surface as the view's camera sees it, whose depths become blocks.
  drawDepths(place, view, camera, renderer) {
    const {gl, layout} = this;
    const target = renderer.drawViewSurface(camera);
    const program = this.programs.use('depth');
    bindTexture(gl, 'surfaces', gl.TEXTURE_2D, target.surface);
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.framebuffer);
    gl.framebufferTextureLayer(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, this.depths, 0, place.page);
    const [x, y, width, height] = [place.x, place.y, ...layout.cell].map((pixels) => pixels / DEPTH_BLOCK_SIDE);
    gl.viewport(x, y, width, height);
    gl.uniform2i(program.uniform('origin'), x, y);
    gl.uniform2i(program.uniform('size'), camera.width, camera.height);
    gl.uniform1f(program.uniform('depth_scale'), depthScale(view));
    gl.uniform1f(program.uniform('pixels'), 1 / layout.scale);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    return target;
  }

  // Another version of the scene. What was stored stays, unless it is of a view that is not there any more; false: it
  // does not fit.
  follow(scene, layout, resident) {
    if (!samePlaces(layout, this.layout) || scene.levels !== this.scene.levels) return false;
    const before = this.scene;
    Object.assign(this, {scene, layout, resident});
    this.slots = new Uint32Array(layout.tiles).fill(NO_SLOT);
    for (const slot of this.there) {
      if (scene.views[slot]?.name === before.views[slot]?.name) {
        this.fill(slot);
      } else {
        this.there.delete(slot);
      }
    }
    this.tileSlots.release();
    this.views.release();
    this.tileSlots = new Table(this.gl, this.slots, 1);
    this.views = new Table(this.gl, viewTable(scene, layout), 4);
    return true;
  }

  release() {
    for (const texture of [this.colours, this.depths]) this.gl.deleteTexture(texture);
    this.tileSlots.release();
    this.views.release();
    this.gl.deleteFramebuffer(this.framebuffer);
  }

  // From now on pictures may show it.
  show(slot) {
    this.fill(slot);
    this.tileSlots.store(this.slots, 1);
    this.there.add(slot);
  }

  fill(slot) {
    const place = this.layout.places[slot];
    const tiles = place.tileColumns * place.tileRows;
    for (let tile = 0; tile < tiles; ++tile) {
      const number = place.firstTile + tile;
      this.slots[number] = this.resident[number] ? slotOfTile(this.layout, place, tile) : NO_SLOT;
    }
  }
}
