// SPDX-License-Identifier: GPL-3.0-or-later
// Chooses the sizes of pictures: interactive frames have as many pixels as the GPU draws in time, still frames up to
// the screen's.
import {MOST_PART_PX} from './renderer.js';
/** @import {Quality, Size} from '../types.d.ts' */

const SLOW_MS = 40;        // an interactive frame that the GPU takes longer for makes the next one smaller
const FAST_MS = 20;        // above a frame of a screen that shows 60 a second
const LEAST_SHARE = 0.2;   // least share of an interactive frame's pixels along a side
const FIRST_SHARE = 0.5;
const DRAFT_SHARE = 0.4;   // share of the pixels along a side below which interactive frames become drafts
const MOST_CHANGE = 1.6;   // factor of the share from one frame to the next
const MOST_CANVAS_PART = 4;       // pixels of the window for one of the canvas along a side, on a slow GPU
const MOST_PIXELS = 2.1e6;        // pixels of an interactive frame
const MOST_STILL_PIXELS = 4.2e6;
const PART_MS = 100;       // that the GPU should take for a part of a still frame
const LEAST_PART_PX = 64;
const FIRST_PASS_MS = 10000;  // a still frame that takes longer is drawn with fewer pixels before
const LEAST_GAIN = 1.5;    // in pixels along a side, from one pass to the next
const NEXT_GAIN = 2;
const SAMPLES_MS = 15000;  // a still frame gets samples at silhouettes where that takes no longer
const SAMPLES_COST = 2;    // cost of a picture with samples, in pictures without

// Pixels for each of the window's along a side, in interactive and in still frames, where the screen has them; `share`:
// of them that interactive frames have, null: as many as the GPU draws in time.
/** @type {Record<Quality, {share: number | null, moving: number, still: number}>} */
const QUALITIES = {
  auto: {share: null, moving: 1, still: 2},
  sharp: {share: 1, moving: 2, still: 2},
  fast: {share: 0.5, moving: 1, still: 1},
};

export class PictureSizes {
  /** @param {HTMLCanvasElement} canvas */
  constructor(canvas) {
    this.canvas = canvas;
    /** @type {Quality} */
    this.quality = 'auto';
    this.share = FIRST_SHARE;
    this.isDraft = false;  // whether interactive frames are drafts
    this.measured = 0;  // interactive frames whose time is known
    /** @type {number | null} */
    this.pixelMs = null;  // that the GPU took for a pixel last
    this.surfaceMs = 0;   // that it took for a still frame's surface last
    this.boxFollows = false;  // CSS gives the canvas no size, so that its box follows its pixels
  }

  /** @param {string} quality */
  setQuality(quality) {
    this.quality = quality === 'sharp' || quality === 'fast' ? quality : 'auto';
    this.share = QUALITIES[this.quality].share ?? this.share;
    if (QUALITIES[this.quality].share !== null) this.isDraft = false;
  }

  // `ratio` pixels for each of the window's, but not more than the screen has, nor than `most` in all.
  /** @param {number} ratio @param {number} most @returns {Size} */
  with(ratio, most) {
    const {width, height} = this.canvas.getBoundingClientRect();
    const wanted = Math.min(window.devicePixelRatio || 1, ratio);
    const share = wanted * Math.min(1, Math.sqrt(most / Math.max(1, width * height * wanted * wanted)));
    return [Math.max(1, Math.round(width * share)), Math.max(1, Math.round(height * share))];
  }

  // Size of the canvas where it shows a still frame.
  whole() {
    return this.with(QUALITIES[this.quality].still, MOST_STILL_PIXELS);
  }

  // Largest size of an interactive frame.
  moving() {
    return this.with(QUALITIES[this.quality].moving, MOST_PIXELS);
  }

  // Size of the next interactive frame.
  /** @returns {Size} */
  next() {
    const [width, height] = this.moving();
    return [Math.max(1, Math.round(width * this.share)), Math.max(1, Math.round(height * this.share))];
  }

  // Returns whether the GPU draws interactive frames of the largest size too late, unless they are drafts.
  get isSlow() {
    return this.isDraft || this.share < 1;
  }

  // Size of a still frame: whole() where the GPU draws interactive frames whole in time.
  /** @returns {Size} */
  still() {
    return this.quality === 'auto' && this.isSlow ? this.moving() : this.whole();
  }

  // Size of the canvas that shows a picture of that size. On a slow GPU it is a half to a quarter of whole() where the
  // picture is not wider, which the browser shows in less time.
  /** @param {{width: number, height: number}} picture @returns {Size} */
  canvasFor({width}) {
    const [across, down] = this.whole();
    if (!this.isSlow || this.boxFollows) return [across, down];
    const part = Math.max(1, Math.min(MOST_CANVAS_PART, Math.floor(across / width)));
    return [Math.ceil(across / part), Math.ceil(down / part)];
  }

  // Sizes of the passes of a still frame, the whole one last: each takes the GPU a bounded time, or is a small gain on
  // the one before.
  /** @returns {Size[]} */
  passes() {
    const [width, height] = this.still();
    const ms = width * height * (this.pixelMs ?? 0);
    /** @type {Size[]} */
    const passes = [];
    let share = Math.max(Math.sqrt(FIRST_PASS_MS / Math.max(1, ms)), LEAST_GAIN * this.share);
    for (; share * LEAST_GAIN < 1; share *= NEXT_GAIN) {
      passes.push([Math.max(1, Math.round(share * width)), Math.max(1, Math.round(share * height))]);
    }
    return [...passes, [width, height]];
  }

  // Fewer pixels where the GPU is slow. The first frame, for which programs are made ready, says nothing.
  /** @param {number} ms */
  adapt(ms) {
    ++this.measured;
    if (QUALITIES[this.quality].share !== null || this.measured < 2) return;
    const change = ms > SLOW_MS ? Math.sqrt(SLOW_MS / ms) : ms < FAST_MS ? MOST_CHANGE : 1;
    this.share = Math.max(LEAST_SHARE, Math.min(1, this.share * Math.max(1 / MOST_CHANGE, change)));
    if (this.share < DRAFT_SHARE) this.isDraft = true;
    else if (this.share === 1 && ms < FAST_MS) this.isDraft = false;
  }

  // Notes that the GPU took `ms` for `pixels`.
  /** @param {number} ms @param {number} pixels */
  noteTime(ms, pixels) {
    this.pixelMs = ms / Math.max(1, pixels);
  }

  // Notes that the GPU took `ms` for a still frame's surface.
  /** @param {number} ms */
  noteSurface(ms) {
    this.surfaceMs = ms;
  }

  // Longest side of a still frame's parts, pixels: what the GPU draws in about PART_MS.
  partPx() {
    const side = this.pixelMs === null ? LEAST_PART_PX : Math.floor(Math.sqrt(PART_MS / Math.max(this.pixelMs, 1e-9)));
    return Math.max(LEAST_PART_PX, Math.min(MOST_PART_PX, side));
  }

  // Returns whether a picture of that size with samples, each part of which needs the surface twice, is drawn in time.
  /** @param {Size} size */
  hasTimeForSamples([width, height]) {
    const parts = Math.ceil(width / MOST_PART_PX) * Math.ceil(height / MOST_PART_PX);
    return SAMPLES_COST * (parts * this.surfaceMs + width * height * (this.pixelMs ?? 0)) < SAMPLES_MS;
  }
}
