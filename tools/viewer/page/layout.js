// SPDX-License-Identifier: GPL-3.0-or-later
// Where photographs are in the texture array: whole, each in a cell of a page, at the largest scale that the memory
// allows. In a model that changes each slot has its place, so that those that stay stay where they are. They are
// scaled so that a tile is a whole number of pixels, then tiles of the model stay tiles. Cells begin
// where all coarser levels have a pixel's border.

// What every WebGL 2 has.
const MOST_SIDE = 2048;
const MOST_PAGES = 256;
const COLOUR_BYTES = 4;
// Depths are in blocks of so many pixels a side (atlas/depth_blocks.h).
export const DEPTH_BLOCK_SIDE = 8;
const DEPTH_BLOCK_BYTES = 16;

const rounded = (value, unit) => Math.ceil(value / unit) * unit;
const multipleOf = (a, b) => {
  let x = a;
  while (x % b !== 0) x += a;
  return x;
};

const changes = (scene) => Boolean(scene.version);
const placesOf = (scene) => changes(scene) ? scene.views.length : scene.views.filter(Boolean).length;

// With tiles of so many pixels a side.
function layoutWith(scene, tile) {
  const scale = tile / scene.tile;
  const views = scene.views.filter(Boolean);
  const scaled = (key) => Math.max(...views.map((view) => Math.ceil(view[key] * scale - 1e-9)));
  const count = placesOf(scene);
  const several = count > MOST_PAGES;
  const unit = several ? multipleOf(tile, DEPTH_BLOCK_SIDE) : DEPTH_BLOCK_SIDE;
  // Between neighbours, room for what linear sampling of the coarsest level reaches.
  const gap = several ? 1 << scene.levels : 0;
  const width = rounded(scaled('width') + gap, unit);
  const height = rounded(scaled('height') + gap, unit);
  const most = [Math.floor(MOST_SIDE / width), Math.floor(MOST_SIDE / height)];
  const perPage = Math.ceil(count / MOST_PAGES);
  const columns = Math.max(1, Math.min(most[0], Math.ceil(Math.sqrt(perPage))));
  const rows = Math.max(1, Math.ceil(perPage / columns));
  const pages = Math.ceil(count / (columns * rows));
  let texels = 0;
  for (let level = 0; level < scene.levels; ++level) texels += (columns * width >> level) * (rows * height >> level);
  return {
    scale, tile, cell: [width, height], columns, rows, pages, size: [columns * width, rows * height],
    fits: width <= MOST_SIDE && height <= MOST_SIDE && rows <= most[1],
    bytes: pages * (COLOUR_BYTES * texels +
        DEPTH_BLOCK_BYTES * columns * width * rows * height / (DEPTH_BLOCK_SIDE * DEPTH_BLOCK_SIDE)),
  };
}

// Where the view with a number begins.
function placeOf(layout, index) {
  const inPage = layout.columns * layout.rows;
  const at = index % inPage;
  return {
    page: Math.floor(index / inPage),
    x: at % layout.columns * layout.cell[0],
    y: Math.floor(at / layout.columns) * layout.cell[1],
  };
}

// The number of a view's place in the array for each of its tiles, or for none.
function addTiles(layout, scene) {
  let first = 0;
  let index = 0;
  layout.slotColumns = Math.ceil(layout.size[0] / layout.tile);
  layout.slotRows = Math.ceil(layout.size[1] / layout.tile);
  layout.places = scene.views.map((view, slot) => {
    if (!view) return null;
    const tileColumns = Math.ceil(view.width / scene.tile - 1e-9);
    const tileRows = Math.ceil(view.height / scene.tile - 1e-9);
    const place = {...placeOf(layout, changes(scene) ? slot : index), firstTile: first, tileColumns, tileRows};
    first += tileColumns * tileRows;
    ++index;
    return place;
  });
  layout.tiles = first;
}

export function makeLayout(scene, bytes) {
  let tile = scene.tile;
  let layout = layoutWith(scene, tile);
  const least = Math.max(1, Math.floor(scene.tile / 8));
  while (tile > least && (!layout.fits || layout.bytes > bytes)) layout = layoutWith(scene, --tile);
  if (!layout.fits) throw new Error('the photographs are too many for this device');
  addTiles(layout, scene);
  return layout;
}

// Whether what is in an array that the one describes is where the other expects it.
export function samePlaces(a, b) {
  return a.tile === b.tile && a.scale === b.scale && [a.size, a.cell, [a.pages]].flat().join() ===
      [b.size, b.cell, [b.pages]].flat().join();
}

export function slotOfTile(layout, place, tile) {
  const column = place.x / layout.tile + tile % place.tileColumns;
  const row = place.y / layout.tile + Math.floor(tile / place.tileColumns);
  return (place.page * layout.slotRows + row) * layout.slotColumns + column;
}
