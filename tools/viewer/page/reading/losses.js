// SPDX-License-Identifier: GPL-3.0-or-later
// The parts of the site that could not be fetched so far, and the line that names them.
/** @import {Texts} from '../texts/texts.js' */
/** @import {TextKey} from '../types.d.ts' */
/** @import {FetchFailure} from './fetching.js' */

// Parts of the model, in the order in which they are told.
/** @satisfies {Record<string, TextKey>} */
const PARTS = /** @type {const} */ ({
  scene: 'partScene',
  views: 'partViews',
  mesh: 'partMesh',
  chunk: 'partChunk',
  coarse: 'partCoarse',
  tables: 'partTables',
  colors: 'partColors',
  version: 'partVersion',
});

/** @typedef {keyof typeof PARTS} LossPart */

export class Losses {
  // `changed` is called with the line after each change; '': nothing is missing.
  /** @param {Texts} texts @param {(line: string) => void} changed */
  constructor(texts, changed) {
    this.texts = texts;
    this.changed = changed;
    /** @type {Map<LossPart, FetchFailure>} */
    this.parts = new Map();
    /** @type {Map<number, FetchFailure>} */
    this.views = new Map();  // for each view slot, its missing photograph or mask
    this.told = '';
  }

  /** @param {LossPart} part @param {FetchFailure} failure */
  notePart(part, failure) {
    this.parts.set(part, failure);
    this.tell();
  }

  /** @param {LossPart} part */
  clearPart(part) {
    if (this.parts.delete(part)) this.tell();
  }

  /** @param {number} slot @param {FetchFailure} failure */
  noteView(slot, failure) {
    this.views.set(slot, failure);
    this.tell();
  }

  /** @param {number} slot */
  clearView(slot) {
    if (this.views.delete(slot)) this.tell();
  }

  // Forgets all losses, for a version that another one has replaced.
  clear() {
    this.parts.clear();
    this.views.clear();
    this.tell();
  }

  // Returns whether anything is missing.
  any() {
    return this.parts.size + this.views.size > 0;
  }

  // Returns whether the server says that a file is gone, which happens if the site has another version by now.
  anyGone() {
    return [...this.parts.values(), ...this.views.values()].some(({gone}) => gone);
  }

  line() {
    if (!this.any()) return '';
    const parts = /** @type {LossPart[]} */ (Object.keys(PARTS)).filter((part) => this.parts.has(part));
    const {texts, views: {size}} = this;
    const names = parts.map((part) => texts.say(PARTS[part]));
    if (size > 0) names.push(texts.say('partPhotographs', {count: size}));
    const [first] = [...this.parts.values(), ...this.views.values()];
    const count = Math.max(1, parts.length + size);
    const sentence = texts.say('missing', {count, parts: texts.list(names), why: first.said});
    return sentence[0].toUpperCase() + sentence.slice(1);
  }

  tell() {
    const line = this.line();
    if (line === this.told) return;
    this.told = line;
    this.changed(line);
  }
}
