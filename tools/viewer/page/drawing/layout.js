// SPDX-License-Identifier: GPL-3.0-or-later
// The texture array that photographs are in: whole, each in a cell of a page. They are scaled to fit the memory, but
// not below what the canvas shows; where that is not enough, there are fewer cells than photographs. They are scaled so
// that a tile is a whole number of pixels, then tiles of the model stay tiles. Cells begin where all coarser levels
// have a pixel's border, and a block's.
import {viewsOf} from '../reading/model.js';
import {TextError} from '../texts/texts.js';
/** @import {Layout, CellPlace, Scene, TexelForm} from '../types.d.ts' */

// Limits of every WebGL 2.
const MOST_PAGE_SIDE = 2048;
const MOST_PAGES = 256;
export const BLOCK_SIDE = 4;  // texels that are compressed together
// Pixels along a side of a block of depths (atlas/views/depth_blocks.h).
export const DEPTH_BLOCK_SIDE = 8;
const DEPTH_BLOCK_BYTES = 16;
const LEAST_CELLS = 8;   // which pictures need; with fewer, photographs are scaled below what the canvas shows
const LEAST_SCALE = 1 / 8;

/** @param {number} value @param {number} unit */
const rounded = (value, unit) => Math.ceil(value / unit) * unit;
/** @param {number} a @param {number} b */
const multipleOf = (a, b) => {
  let x = a;
  while (x % b !== 0) x += a;
  return x;
};

// The layout with `count` cells, whose tiles have `tile` pixels a side. `form`: see photograph_forms.js.
/**
 * @param {Scene} scene
 * @param {TexelForm} form
 * @param {number} tile
 * @param {number} count
 * @returns {Layout}
 */
function layoutWith(scene, form, tile, count) {
  const scale = tile / scene.tile;
  const views = viewsOf(scene);
  const scaled = (/** @type {'width' | 'height'} */ key) =>
      Math.max(...views.map((view) => Math.ceil(view[key] * scale - 1e-9)));
  const several = count > MOST_PAGES;
  const blocks = form.blocks ? BLOCK_SIDE << (scene.levels - 1) : 1;
  const besides = multipleOf(DEPTH_BLOCK_SIDE, blocks);
  const unit = several ? multipleOf(tile, besides) : besides;
  // Between neighbours, room for what linear sampling of the coarsest level reaches.
  const gap = several ? 1 << scene.levels : 0;
  const width = rounded(scaled('width') + gap, unit);
  const height = rounded(scaled('height') + gap, unit);
  const most = [Math.floor(MOST_PAGE_SIDE / width), Math.floor(MOST_PAGE_SIDE / height)];
  const perPage = Math.ceil(count / MOST_PAGES);
  const columns = Math.max(1, Math.min(most[0], Math.ceil(Math.sqrt(perPage))));
  const rows = Math.max(1, Math.ceil(perPage / columns));
  const pages = Math.ceil(count / (columns * rows));
  let texels = 0;
  for (let level = 0; level < scene.levels; ++level) texels += (columns * width >> level) * (rows * height >> level);
  return {
    form, scale, tile, count, cell: [width, height], columns, rows, pages, size: [columns * width, rows * height],
    fits: width <= MOST_PAGE_SIDE && height <= MOST_PAGE_SIDE && rows <= most[1],
    bytes: pages * (form.texelBytes * texels +
        DEPTH_BLOCK_BYTES * columns * width * rows * height / (DEPTH_BLOCK_SIDE * DEPTH_BLOCK_SIDE)),
    slotColumns: Math.ceil(columns * width / tile),
    slotRows: Math.ceil(rows * height / tile),
    ...viewTiles(scene),
  };
}

// Returns the corner of a cell.
/** @param {Layout} layout @param {number} index @returns {CellPlace} */
export function placeOf(layout, index) {
  const inPage = layout.columns * layout.rows;
  const at = index % inPage;
  return {
    page: Math.floor(index / inPage),
    x: at % layout.columns * layout.cell[0],
    y: Math.floor(at / layout.columns) * layout.cell[1],
  };
}

// The tiles of each view, which are numbered one view after another.
/** @param {Scene} scene */
function viewTiles(scene) {
  let first = 0;
  const views = scene.views.map((view) => {
    if (!view) return null;
    const columns = Math.ceil(view.width / scene.tile - 1e-9);
    const rows = Math.ceil(view.height / scene.tile - 1e-9);
    const tiles = {first, columns, count: columns * rows};
    first += tiles.count;
    return tiles;
  });
  return {views, tiles: first};
}

// The layout of at most `bytes`. `shown`: the scale at which photographs have as many pixels as the canvas. Throws
// where the device takes no array that is large enough for the least scale.
/** @param {Scene} scene @param {TexelForm} form @param {number} bytes @param {number} shown */
export function makeLayout(scene, form, bytes, shown) {
  let tile = scene.tile;
  // A model that changes will have more of them.
  let count = scene.version ? scene.views.length : viewsOf(scene).length;
  let layout = layoutWith(scene, form, tile, count);
  const tooLarge = () => !layout.fits || layout.bytes > bytes;
  const scaleDown = (/** @type {number} */ scale) => {
    while (tile > Math.max(1, Math.ceil(scene.tile * scale)) && tooLarge()) {
      layout = layoutWith(scene, form, --tile, count);
    }
  };
  scaleDown(Math.max(LEAST_SCALE, Math.min(1, shown)));
  while (count > LEAST_CELLS && tooLarge()) {
    count = Math.max(LEAST_CELLS, Math.min(count - 1, Math.floor(count * bytes / layout.bytes)));
    layout = layoutWith(scene, form, tile, count);
  }
  scaleDown(LEAST_SCALE);
  if (!layout.fits) throw new TextError('tooMany');
  return layout;
}

// Returns whether both layouts have the same places, so that an array of the one may be used with the other.
/** @param {Layout} a @param {Layout} b */
export function samePlaces(a, b) {
  return a.form === b.form && a.tile === b.tile && a.scale === b.scale &&
      [a.size, a.cell, [a.count]].flat().join() === [b.size, b.cell, [b.count]].flat().join();
}

// The number of a tile's place in the array. `columns`: tiles in a row of its view.
/** @param {Layout} layout @param {CellPlace} place @param {number} columns @param {number} tile */
export function slotOfTile(layout, place, columns, tile) {
  const column = place.x / layout.tile + tile % columns;
  const row = place.y / layout.tile + Math.floor(tile / columns);
  return (place.page * layout.slotRows + row) * layout.slotColumns + column;
}
