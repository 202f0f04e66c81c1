// SPDX-License-Identifier: GPL-3.0-or-later
// A table that shaders read by number, in which parts of a surface take and give back ranges of entries.
import {TABLE_WIDTH, Table} from './tables.js';

const GROWTH = 1.5;

// A range of a pool's entries, in whole rows of its texture.
/** @typedef {{first: number, rows: number}} PoolRange */

export class TablePool {
  // `components` of an entry: 1, 2 or 4 numbers.
  /** @param {WebGL2RenderingContext} gl @param {number} components */
  constructor(gl, components) {
    this.gl = gl;
    this.components = components;
    this.values = new Uint32Array(TABLE_WIDTH * components);
    this.table = new Table(gl, this.values, components);
    /** @type {PoolRange[]} */
    this.taken = [];  // in the order of their entries
  }

  get bytes() {
    return this.table.bytes;
  }

  /** @param {PoolRange} range */
  bytesOf({rows}) {
    return Table.bytesOf(rows * TABLE_WIDTH, this.components);
  }

  release() {
    this.table.release();
  }

  // Takes a range for `entries`; the table grows where no gap has room for them.
  /** @param {number} entries @returns {PoolRange} */
  take(entries) {
    const rows = Math.max(1, Math.ceil(entries / TABLE_WIDTH));
    let [row, at] = [0, 0];
    for (; at < this.taken.length && this.taken[at].first / TABLE_WIDTH - row < rows; ++at) {
      row = this.taken[at].first / TABLE_WIDTH + this.taken[at].rows;
    }
    if (row + rows > this.table.rows) this.grow(row + rows);
    const range = {first: row * TABLE_WIDTH, rows};
    this.taken.splice(at, 0, range);
    return range;
  }

  /** @param {PoolRange} range */
  give(range) {
    this.taken.splice(this.taken.indexOf(range), 1);
  }

  /** @param {number} rows */
  grow(rows) {
    // The first range of an empty pool is often the only one.
    const room = this.taken.length === 0 ? rows : Math.max(rows, Math.ceil(GROWTH * this.table.rows));
    const values = new Uint32Array(room * TABLE_WIDTH * this.components);
    values.set(this.values);
    const table = new Table(this.gl, values, this.components);
    this.table.release();
    [this.table, this.values] = [table, values];
  }

  // The numbers of a range, to be changed in place; stored() brings them to the GPU.
  /** @param {PoolRange} range */
  numbers({first, rows}) {
    return this.values.subarray(first * this.components, (first + rows * TABLE_WIDTH) * this.components);
  }

  /** @param {PoolRange} range */
  stored(range) {
    this.table.storeRows(range.first / TABLE_WIDTH, range.rows, this.numbers(range));
  }
}
