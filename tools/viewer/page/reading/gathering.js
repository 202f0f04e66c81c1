// SPDX-License-Identifier: GPL-3.0-or-later
// Gathers the files that are asked for at about the same time into one request, which the server of a model that
// changes answers (http/files_together.h): its surface is in some hundred small files.
import {FetchFailure} from './fetching.js';
/** @import {Fetching} from './fetching.js' */

const ADDRESS = 'together';
const MOST_CHARACTERS = 8000;  // of the names in a request
const NOT_TOGETHER = 0xFFFFFFFF;

// Returns the files of an answer; null where one is not in it.
/** @param {Uint8Array<ArrayBuffer>} bytes @param {number} count */
export function filesOfAnswer(bytes, count) {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  /** @type {(Uint8Array<ArrayBuffer> | null)[]} */
  const files = [];
  let at = 0;
  while (files.length < count) {
    const length = view.getUint32(at, true);
    at += 4;
    if (length === NOT_TOGETHER) {
      files.push(null);
      continue;
    }
    if (at + length > bytes.length) throw new Error('it ends within a file');
    files.push(bytes.slice(at, at + length));  // a file of its own, so that none keeps the others' bytes
    at += length;
  }
  if (at !== bytes.length) throw new Error('it has more than was asked for');
  return files;
}

export class Gathering {
  // `base`: the address of the folder that the files are in.
  /** @param {Fetching} fetching @param {string} base */
  constructor(fetching, base) {
    this.fetching = fetching;
    this.base = base;
    this.answers = true;  // false: the server does not know such requests
    /** @type {Map<string, ((bytes: Uint8Array<ArrayBuffer> | null) => void)[]>} */
    this.waiting = new Map();
  }

  // Resolves to a file's bytes; null: it has to be asked for alone.
  /** @param {string} name @returns {Promise<Uint8Array<ArrayBuffer> | null>} */
  bytes(name) {
    if (!this.answers) return Promise.resolve(null);
    return new Promise((resolve) => {
      if (this.waiting.size === 0) setTimeout(() => this.askForAll());
      const asking = this.waiting.get(name);
      if (asking) asking.push(resolve);
      else this.waiting.set(name, [resolve]);
    });
  }

  askForAll() {
    /** @type {string[]} */
    let names = [];
    let characters = 0;
    const {waiting} = this;
    this.waiting = new Map();
    for (const name of waiting.keys()) {
      if (characters + name.length >= MOST_CHARACTERS) {
        this.ask(names, waiting);
        [names, characters] = [[], 0];
      }
      names.push(name);
      characters += name.length + 1;
    }
    this.ask(names, waiting);
  }

  // Whatever fails is asked for alone, which says why.
  /** @param {string[]} names @param {Gathering['waiting']} waiting */
  async ask(names, waiting) {
    /** @type {(Uint8Array<ArrayBuffer> | null)[]} */
    let files = [];
    try {
      if (names.length > 1) files = await this.answer(names);
    } catch (error) {
      if (error instanceof FetchFailure && error.gone) this.answers = false;
    }
    names.forEach((name, number) => {
      for (const resolve of waiting.get(name) ?? []) resolve(files[number] ?? null);
    });
  }

  /** @param {string[]} names */
  answer(names) {
    const address = new URL(`${ADDRESS}?${names.join('&')}`, this.base);
    return this.fetching.get(ADDRESS, address, undefined, async (blob) =>
        filesOfAnswer(new Uint8Array(await blob.arrayBuffer()), names.length), false);
  }
}
