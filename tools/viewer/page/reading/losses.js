// SPDX-License-Identifier: GPL-3.0-or-later
// The parts of the site that could not be fetched so far, and the line that names them.
/** @import {FetchFailure} from './fetching.js' */

// Parts of the model, in the order in which they are told.
const PARTS = {
  scene: 'the model',
  views: 'the list of photographs',
  mesh: 'the fine mesh',
  chunk: 'a part of the fine mesh',
  coarse: 'the coarse mesh',
  tables: 'the table of photographs',
  colors: 'the newest colours',
  version: 'the newest version of the model',
};
const SHOWN_INSTEAD = 'What is there is shown, and the page tries again.';

/** @typedef {keyof typeof PARTS} LossPart */

/** @param {string[]} names */
const listed = (names) => names.length < 2 ? names.join() : `${names.slice(0, -1).join(', ')} and ${names.at(-1)}`;

export class Losses {
  // `changed` is called with the line after each change; '': nothing is missing.
  /** @param {(line: string) => void} changed */
  constructor(changed) {
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
    const names = parts.map((part) => PARTS[part]);
    const {size} = this.views;
    if (size > 0) names.push(size === 1 ? '1 photograph' : `${size} photographs`);
    const [first] = [...this.parts.values(), ...this.views.values()];
    const verb = names.length > 1 || size > 1 ? 'are' : 'is';
    const sentence = `${listed(names)} ${verb} missing: ${first.message}. ${SHOWN_INSTEAD}`;
    return sentence[0].toUpperCase() + sentence.slice(1);
  }

  tell() {
    const line = this.line();
    if (line === this.told) return;
    this.told = line;
    this.changed(line);
  }
}
