// SPDX-License-Identifier: GPL-3.0-or-later
// The photographs on the GPU. A view comes as a picture and a mask; its depths are drawn from the mesh when it comes.
// Each is in a cell of the texture array; where there are fewer cells than views, one takes another's.
import {BlockCompressor} from './block_compressor.js';
import {scaledCamera} from '../camera.js';
import {GlObjects} from './gl_objects.js';
import {DEPTH_BLOCK_SIDE, placeOf, samePlaces, slotOfTile} from './layout.js';
import {MOST_SIDE, loadMask, loadPhotograph, viewsOf} from '../reading/model.js';
import {NO_SLOT, SPARE_UNIT, Table, VIEW_TEXELS, bindTexture, depthScale, makeTexture, viewTable} from './tables.js';
/** @import {FetchedView, Layout, CellPlace, Scene, Size, TexelForm, View} from '../types.d.ts' */
/** @import {Programs} from './programs.js' */
/** @import {SiteFiles} from '../reading/site_files.js' */
/** @import {Renderer} from './renderer.js' */

const PICTURE_PIXEL_BYTES = 4 + 1;  // a picture before it is stored, with its mask
const ALL_VALID = 254;
const DEPTH_PIXEL_BYTES = 4;        // a depth from which the view's depths are found

// Lets pixels go to the GPU as they are.
/** @param {WebGL2RenderingContext} gl */
function unpackAsItIs(gl) {
  gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
  gl.pixelStorei(gl.UNPACK_PREMULTIPLY_ALPHA_WEBGL, false);
  gl.pixelStorei(gl.UNPACK_COLORSPACE_CONVERSION_WEBGL, gl.NONE);
}

export class Photographs {
  // `resident`: for each tile of the scene, 1 or 0.
  /**
   * @param {WebGL2RenderingContext} gl
   * @param {Programs} programs
   * @param {Scene} scene
   * @param {Layout} layout
   * @param {Uint32Array} resident
   */
  constructor(gl, programs, scene, layout, resident) {
    this.gl = gl;
    this.programs = programs;
    this.scene = scene;
    this.layout = layout;
    this.resident = resident;
    this.objects = new GlObjects(gl);
    this.slots = new Uint32Array(layout.tiles).fill(NO_SLOT);
    this.tileSlots = new Table(gl, this.slots, 1);
    this.views = new Table(gl, viewTable(scene, layout), 4);
    this.colours = this.array(layout.form.internal, layout.size, scene.levels, gl.LINEAR);
    this.depths = this.array(gl.RGBA32UI, layout.size.map((side) => side / DEPTH_BLOCK_SIDE), 1, gl.NEAREST);
    this.bytes = layout.bytes + this.tileSlots.bytes + this.views.bytes;
    /** @type {Map<number, number>} */
    this.cells = new Map();  // the cell of each view slot that is there
    this.free = Array.from({length: layout.count}, (_, cell) => cell).reverse();
    this.framebuffer = this.objects.framebuffer();
    /** @type {BlockCompressor | null} */
    this.compressor = null;
    for (const pass of ['depth', layout.form.blocks ? layout.form.name : 'photograph']) programs.ready(pass);
  }

  /** @param {number} format @param {number[]} size @param {number} levels @param {number} filter */
  array(format, size, levels, filter) {
    const {gl, layout} = this;
    const texture = this.objects.texture();
    gl.activeTexture(gl.TEXTURE0 + SPARE_UNIT);
    gl.bindTexture(gl.TEXTURE_2D_ARRAY, texture);
    gl.texStorage3D(gl.TEXTURE_2D_ARRAY, levels, format, size[0], size[1], layout.pages);
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

  // Fetches over the network what store() needs of a view.
  /** @param {SiteFiles} files @param {View} view @param {number} slot @returns {Promise<FetchedView>} */
  static async fetched(files, view, slot) {
    const [picture, mask] = await Promise.all([loadPhotograph(files, view), loadMask(files, view)]);
    return {slot, picture, mask};
  }

  // On the GPU besides what the layout says: tables, and what store() takes for a while, for the largest photograph at
  // its own scale.
  /** @param {Scene} scene @param {TexelForm} form @param {number} tiles */
  static bytesBesides(scene, form, tiles) {
    const views = viewsOf(scene);
    const scale = (/** @type {View} */ view) => Math.min(1, MOST_SIDE / Math.max(view.width, view.height));
    const width = Math.max(...views.map((view) => Math.ceil(view.width * scale(view))));
    const height = Math.max(...views.map((view) => Math.ceil(view.height * scale(view))));
    const blocks = form.blocks ? BlockCompressor.bytesFor([width, height]) : 0;
    const tables = Table.bytesOf(tiles, 1) + Table.bytesOf(VIEW_TEXELS * scene.views.length, 4);
    return tables + (PICTURE_PIXEL_BYTES + DEPTH_PIXEL_BYTES) * width * height + blocks;
  }

  // In the place of another view where no cell is free, unless it is there already. `renderer` draws the depths.
  /** @param {FetchedView} fetched @param {Renderer} renderer @param {number | undefined} instead */
  store({slot, picture, mask}, renderer, instead) {
    const {gl} = this;
    const view = this.scene.views[slot];
    if (!view) return;
    const place = this.placeFor(slot, instead);
    const passing = new GlObjects(gl);
    const image = makeTexture(passing, gl.RGBA8, picture.width, picture.height);
    unpackAsItIs(gl);
    gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, gl.RGBA, gl.UNSIGNED_BYTE, picture);
    bindTexture(gl, 'image', gl.TEXTURE_2D, image);
    this.bindMask(passing, mask, picture);
    renderer.setState();
    const pixels = picture.width / view.width / this.layout.scale;  // of the picture in a texel, along a side
    this.storeLevels(place, pixels);
    this.drawDepths(place, view, renderer, pixels);
    renderer.noteBytes(PICTURE_PIXEL_BYTES * picture.width * picture.height + (this.compressor?.bytes ?? 0));
    passing.release();
    picture.close();
    mask?.close();
    this.fill(slot);
    this.tileSlots.store(this.slots, 1);
  }

  // Binds the mask of a picture; null: all of it is valid.
  /** @param {GlObjects} passing @param {ImageBitmap | null} mask @param {{width: number, height: number}} size */
  bindMask(passing, mask, {width, height}) {
    const {gl} = this;
    const valid = makeTexture(passing, gl.R8, width, height);
    unpackAsItIs(gl);
    if (mask) {
      gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, gl.RED, gl.UNSIGNED_BYTE, mask);
    } else {
      const all = new Uint8Array(width * height).fill(ALL_VALID);
      gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, width, height, gl.RED, gl.UNSIGNED_BYTE, all);
    }
    bindTexture(gl, 'mask', gl.TEXTURE_2D, valid);
  }

  // Draws the depths of a view that is there anew. `mask`: null where all of it is valid.
  /** @param {number} slot @param {ImageBitmap | null} mask @param {Renderer} renderer */
  storeDepths(slot, mask, renderer) {
    const view = this.scene.views[slot];
    const cell = this.cells.get(slot);
    if (!view || cell === undefined) return;
    const passing = new GlObjects(this.gl);
    const size = mask ?? {width: 1, height: 1};
    this.bindMask(passing, mask, size);
    renderer.setState();
    this.drawDepths(placeOf(this.layout, cell), view, renderer, size.width / view.width / this.layout.scale);
    passing.release();
  }

  /** @param {number} slot @param {number | undefined} instead */
  placeFor(slot, instead) {
    if (this.free.length === 0 && instead !== undefined && !this.cells.has(slot)) this.drop(instead);
    const cell = this.cells.get(slot) ?? this.free.pop();
    if (cell === undefined) throw new Error(`there is no room for view ${slot}`);
    this.cells.set(slot, cell);
    return placeOf(this.layout, cell);
  }

  // Its cell is for another one.
  /** @param {number} slot */
  drop(slot) {
    const tiles = this.layout.views[slot];
    const cell = this.cells.get(slot);
    if (tiles) this.slots.fill(NO_SLOT, tiles.first, tiles.first + tiles.count);
    if (cell !== undefined) this.free.push(cell);
    this.cells.delete(slot);
  }

  // Means over what a texel covers, in the page and at each of its coarser levels.
  /** @param {CellPlace} place @param {number} inTexel */
  storeLevels(place, inTexel) {
    const {gl, layout, scene} = this;
    if (layout.form.blocks) this.compressor ??= new BlockCompressor(gl, this.programs, layout.form, layout.cell);
    for (let level = 0; level < scene.levels; ++level) {
      const [x, y, width, height] = [place.x, place.y, ...layout.cell].map((v) => v >> level);
      /** @type {Size} */
      const size = [width, height];
      const pixels = 2 ** level * inTexel;
      if (this.compressor) {
        const at = {x, y, page: place.page};
        this.compressor.store(this.colours, level, at, size, pixels);
      } else {
        this.drawLevel(level, {x, y, page: place.page}, size, pixels);
      }
    }
  }

  /** @param {number} level @param {CellPlace} place @param {Size} size @param {number} pixels */
  drawLevel(level, {x, y, page}, size, pixels) {
    const {gl} = this;
    const program = this.programs.use('photograph');
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.framebuffer);
    gl.framebufferTextureLayer(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, this.colours, level, page);
    gl.viewport(x, y, ...size);
    gl.uniform2i(program.uniform('origin'), x, y);
    gl.uniform1f(program.uniform('pixels'), pixels);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
  }

  // Frees what is only needed while views come.
  /** @param {Renderer} renderer */
  rest(renderer) {
    this.compressor?.release();
    this.compressor = null;
    renderer.targets.drop('view');
  }

  // The surface as the view's camera sees it, whose depths become blocks.
  /** @param {CellPlace} place @param {View} view @param {Renderer} renderer @param {number} inPixel */
  drawDepths(place, view, renderer, inPixel) {
    const {gl, layout, scene} = this;
    const camera = scaledCamera(view, layout.scale);
    const seen = renderer.drawViewDepths(camera);
    const program = this.programs.use('depth');
    bindTexture(gl, 'seen_depths', gl.TEXTURE_2D, seen);
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.framebuffer);
    gl.framebufferTextureLayer(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, this.depths, 0, place.page);
    const [x, y, width, height] = [place.x, place.y, ...layout.cell].map((pixels) => pixels / DEPTH_BLOCK_SIDE);
    gl.viewport(x, y, width, height);
    gl.uniform2i(program.uniform('origin'), x, y);
    gl.uniform2i(program.uniform('size'), camera.width, camera.height);
    gl.uniform1f(program.uniform('nearest'), depthScale(view) / scene.near_depth);
    gl.uniform1f(program.uniform('pixels'), inPixel);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
  }

  // Another version of the scene. What was stored stays, unless it is of a view that is not there any more; false: it
  // does not fit.
  /** @param {Scene} scene @param {Layout} layout @param {Uint32Array} resident */
  follow(scene, layout, resident) {
    if (!samePlaces(layout, this.layout) || scene.levels !== this.scene.levels) return false;
    const before = this.scene;
    for (const slot of [...this.cells.keys()]) {
      if (scene.views[slot]?.name !== before.views[slot]?.name) this.drop(slot);
    }
    this.scene = scene;
    this.layout = layout;
    this.resident = resident;
    this.slots = new Uint32Array(layout.tiles).fill(NO_SLOT);
    for (const slot of this.cells.keys()) this.fill(slot);
    this.tileSlots.release();
    this.views.release();
    this.tileSlots = new Table(this.gl, this.slots, 1);
    this.views = new Table(this.gl, viewTable(scene, layout), 4);
    return true;
  }

  release() {
    this.objects.release();
    this.compressor?.release();
    this.tileSlots.release();
    this.views.release();
  }

  // From now on pictures may show it.
  /** @param {number} slot */
  fill(slot) {
    const tiles = this.layout.views[slot];
    const cell = this.cells.get(slot);
    if (!tiles || cell === undefined) return;
    const place = placeOf(this.layout, cell);
    const {first, columns, count} = tiles;
    for (let tile = 0; tile < count; ++tile) {
      this.slots[first + tile] = this.resident[first + tile] ? slotOfTile(this.layout, place, columns, tile) : NO_SLOT;
    }
  }
}
