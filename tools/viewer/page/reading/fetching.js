// SPDX-License-Identifier: GPL-3.0-or-later
// Requests of the page over the network; no other module makes any. A request that fails is made again, after pauses
// that grow. An answer that is cut short, stalls or cannot be decoded has failed too.
import {TextError, saidOf} from '../texts/texts.js';
/** @import {FilePart, NetworkOptions, Said} from '../types.d.ts' */

const TRIES = 5;
const PAUSE_MS = 300;
const PAUSE_GROWTH = 2;
const MOST_PAUSE_MS = 60000;
const SPREAD = 0.5;  // a pause is shorter by at most this share, by chance
const STALLED_MS = 20000;
const LATER_MS = 10000;
const GONE = [404, 410];
const TRIED_AGAIN = [408, 425, 429];  // other answers from 400 to 499 are final

// A file that could not be had. `gone`: the server says that it has no such file.
export class FetchFailure extends TextError {
  // `final`: another try at once would end the same way.
  /** @param {string} name @param {string | Said} why @param {{gone?: boolean, final?: boolean}} [what] */
  constructor(name, why, {gone = false, final = false} = {}) {
    super('notLoaded', {name, why});
    this.gone = gone;
    this.final = final;
  }
}

export class Fetching {
  /** @param {NetworkOptions} options */
  constructor({
    tries = TRIES, pauseMs = PAUSE_MS, stalledMs = STALLED_MS, laterMs = LATER_MS, random = Math.random, signal,
  } = {}) {
    this.tries = tries;
    this.pauseMs = pauseMs;
    this.stalledMs = stalledMs;
    this.laterMs = laterMs;
    this.random = random;
    this.signal = signal;
    // Told how many bytes of a file have come so far, and how many there are; null: that is not known.
    /** @type {(name: string, came: number, size: number | null) => void} */
    this.heard = () => {};
  }

  // Returns the result of `decode` for a file's bytes, or a part's. `size`: the file's bytes, if known.
  // `anew`: not from the browser's cache. Throws FetchFailure after the last try, and the signal's reason once it is
  // aborted.
  /**
   * @template T
   * @param {string} name
   * @param {URL} address
   * @param {number | undefined} size
   * @param {(blob: Blob) => Promise<T>} decode
   * @param {boolean} anew
   * @param {FilePart} [part]
   * @returns {Promise<T>}
   */
  async get(name, address, size, decode, anew, part) {
    for (let number = 1;; ++number) {
      try {
        const blob = await this.answer(name, address, size, anew || number > 1, part);
        return await decoded(name, blob, decode);
      } catch (error) {
        this.signal?.throwIfAborted();
        if (!(error instanceof FetchFailure) || error.final || number >= this.tries) throw error;
      }
      await this.pause(this.pauseMs, number);
    }
  }

  // Waits as long as befits the number of tries so far, from 1; less where the browser says that it is online again.
  /** @param {number} firstMs @param {number} number */
  async pause(firstMs, number) {
    const ms = Math.min(MOST_PAUSE_MS, firstMs * PAUSE_GROWTH ** (number - 1)) * (1 - SPREAD * this.random());
    const {signal} = this;
    await /** @type {Promise<void>} */ (new Promise((resolve) => {
      const end = () => {
        clearTimeout(timer);
        removeEventListener('online', end);
        signal?.removeEventListener('abort', end);
        resolve();
      };
      const timer = setTimeout(end, ms);
      addEventListener('online', end);
      signal?.addEventListener('abort', end);
    }));
    signal?.throwIfAborted();
  }

  // One try.
  /**
   * @param {string} name
   * @param {URL} address
   * @param {number | undefined} size
   * @param {boolean} anew
   * @param {FilePart} [part]
   */
  async answer(name, address, size, anew, part) {
    const watch = new Watch(this.stalledMs, this.signal);
    try {
      const headers = part && {Range: `bytes=${part.from}-${part.from + part.length - 1}`};
      const options = {signal: watch.signal, cache: /** @type {RequestCache} */ (anew ? 'reload' : 'default'), headers};
      const response = await fetch(address, options).catch(async (error) => {
        if (!watch.signal.aborted && await mayNotBeRead(address)) throw notAllowed(name, address);
        throw error;
      });
      if (!response.ok) throw refusal(name, response.status);
      const promised = part?.length ?? size ?? lengthOf(response);
      const all = await body(response, watch, (came) => this.heard(name, came, promised));
      const blob = response.status === 206 ? all : slicePart(all, part);  // some servers send the whole file
      if (promised !== null && blob.size !== promised) {
        throw new FetchFailure(name, {key: 'whyBytes', values: {came: blob.size, promised}});
      }
      return blob;
    } catch (error) {
      if (error instanceof FetchFailure) throw error;
      throw new FetchFailure(name, watch.stalled ? {key: 'whyStalls'} : saidOf(error));
    } finally {
      watch.end();
    }
  }

  // Shows a picture in an <img>, for which the browser makes the request, and makes it again where it fails.
  /** @param {HTMLImageElement} image @param {string} address */
  show(image, address) {
    let number = 1;
    image.addEventListener('error', async () => {
      if (number >= this.tries) return;
      try {
        await this.pause(this.pauseMs, number++);
      } catch {
        return;  // the page asks for nothing any more
      }
      image.removeAttribute('src');
      image.src = address;
    });
    image.src = address;
  }
}

// Ends a try that stalls, or whose caller gives up.
class Watch {
  /** @param {number} stalledMs @param {AbortSignal | undefined} outer */
  constructor(stalledMs, outer) {
    this.controller = new AbortController();
    this.signal = this.controller.signal;
    this.stalledMs = stalledMs;
    this.stalled = false;
    this.outer = outer;
    this.stop = () => this.controller.abort();
    if (outer?.aborted) this.stop();
    outer?.addEventListener('abort', this.stop);
    this.timer = 0;
    this.heard();
  }

  // Something came.
  heard() {
    clearTimeout(this.timer);
    this.timer = setTimeout(() => {
      this.stalled = true;
      this.stop();
    }, this.stalledMs);
  }

  end() {
    clearTimeout(this.timer);
    this.outer?.removeEventListener('abort', this.stop);
  }
}

/** @param {Response} response @param {Watch} watch @param {(came: number) => void} heard */
async function body(response, watch, heard) {
  /** @type {BlobPart[]} */
  const parts = [];
  const reader = response.body?.getReader();
  let came = 0;
  for (let read = await reader?.read(); read && !read.done; read = await reader?.read()) {
    watch.heard();
    parts.push(read.value);
    came += read.value.byteLength;
    heard(came);
  }
  return new Blob(parts, {type: response.headers.get('Content-Type') ?? ''});
}

// Bytes of the body, by its header; null: it does not say, or says how many come compressed.
/** @param {Response} response */
function lengthOf({headers}) {
  const length = headers.get('Content-Length');
  return length === null || headers.has('Content-Encoding') ? null : Number(length);
}

/** @param {string} name @param {number} status */
function refusal(name, status) {
  const final = status >= 400 && status < 500 && !TRIED_AGAIN.includes(status);
  return new FetchFailure(name, {key: 'whyStatus', values: {status}}, {gone: GONE.includes(status), final});
}

// Returns whether another site answers but does not let this page read the answer, which browsers do not tell apart
// from an answer that never comes.
/** @param {URL} address */
async function mayNotBeRead(address) {
  if (address.origin === location.origin) return false;
  /** @param {RequestMode} mode */
  const answers = (mode) => fetch(address, {method: 'HEAD', cache: 'no-store', mode}).then(() => true, () => false);
  return await answers('no-cors') && !await answers('cors');
}

/** @param {string} name @param {URL} address */
const notAllowed = (name, address) => new FetchFailure(
    name, {key: 'whyForbidden', values: {site: address.origin, page: location.origin}}, {final: true});

/** @param {Blob} blob @param {FilePart} [part] */
export const slicePart = (blob, part) => part ? blob.slice(part.from, part.from + part.length, blob.type) : blob;

/**
 * @template T, Content
 * @param {string} name
 * @param {Content} content
 * @param {(content: Content) => Promise<T>} decode
 */
export async function decoded(name, content, decode) {
  try {
    return await decode(content);
  } catch (error) {
    throw new FetchFailure(name, {key: 'whyDamaged', values: {what: saidOf(error)}});
  }
}
