// SPDX-License-Identifier: GPL-3.0-or-later
// The site's files: beside the page on a server, or inside of it (site.cpp, write_one_page). A name that ends in
// "#FROM+LENGTH" is of these bytes of a file.
import {Fetching, decoded, slicePart} from './fetching.js';
import {Gathering} from './gathering.js';
/** @import {NetworkOptions} from '../types.d.ts' */

export class SiteFiles {
  // `base`: the address of the folder that they are in.
  /** @param {string} base @param {NetworkOptions} [network] */
  constructor(base, network) {
    this.base = base;
    this.fetching = new Fetching(network);
    /** @type {Gathering | null} */
    this.gathering = null;
    /** @type {Map<string, HTMLScriptElement>} */
    this.inside = new Map();
    /** @type {NodeListOf<HTMLScriptElement>} */
    const elements = document.querySelectorAll('script[data-file]');
    for (const element of elements) this.inside.set(element.dataset.file ?? '', element);
    /** @type {Record<string, number>} */
    this.sizes = {};  // bytes, of files whose size the manifest says
  }

  // Returns the result of `decode` for a file. `anew`: the server's present file. Throws FetchFailure if it cannot be
  // had.
  /**
   * @template T
   * @param {string} name
   * @param {(blob: Blob) => Promise<T>} decode
   * @returns {Promise<T>}
   */
  async read(name, decode, anew = false) {
    const [, file, from, length] = /^([^#]*)(?:#(\d+)\+(\d+))?$/.exec(name) ?? [name, name];
    const element = this.inside.get(file);
    const part = from === undefined ? undefined : {from: Number(from), length: Number(length)};
    if (element) return decoded(name, slicePart(blobOf(element), part), decode);
    return this.fetching.get(name, new URL(file, this.base), this.sizes[name], decode, anew, part);
  }

  /**
   * @template T
   * @param {string} name
   * @param {(bytes: Uint8Array<ArrayBuffer>) => Promise<T>} decode
   */
  array(name, decode, anew = false) {
    return this.read(name, async (blob) => decode(new Uint8Array(await blob.arrayBuffer())), anew);
  }

  // From now on small files that are asked for at about the same time may come in one answer.
  gather() {
    this.gathering = new Gathering(this.fetching, this.base);
  }

  // The same as array(), for one of many small files.
  /**
   * @template T
   * @param {string} name
   * @param {(bytes: Uint8Array<ArrayBuffer>) => Promise<T>} decode
   */
  async smallArray(name, decode) {
    const bytes = !this.gathering || this.inside.has(name) || name.includes('#') ? null :
      await this.gathering.bytes(name);
    return bytes ? decoded(name, bytes, decode) : this.array(name, decode);
  }

  /** @param {string} name */
  json(name, anew = false) {
    return this.read(name, async (blob) => JSON.parse(await blob.text()), anew);
  }

  // In an <img>; a file inside of a page by a data address, which needs no memory of its own until it is shown.
  /** @param {HTMLImageElement} image @param {string} name */
  show(image, name) {
    if (name.includes('#')) {
      this.showPart(image, name).catch(() => {});  // it stays without a picture
      return;
    }
    const element = this.inside.get(name);
    this.fetching.show(
        image,
        element ? `data:${element.dataset.type};base64,${element.textContent}` : new URL(name, this.base).href);
  }

  /** @param {HTMLImageElement} image @param {string} name */
  async showPart(image, name) {
    const address = URL.createObjectURL(await this.read(name, async (blob) => blob));
    image.addEventListener('load', () => URL.revokeObjectURL(address), {once: true});
    image.src = address;
  }
}

/** @param {HTMLScriptElement} element */
function blobOf(element) {
  const text = atob(element.textContent ?? '');
  const bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; ++i) bytes[i] = text.charCodeAt(i);
  return new Blob([bytes], {type: element.dataset.type});
}
