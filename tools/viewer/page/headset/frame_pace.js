// SPDX-License-Identifier: GPL-3.0-or-later
// Chooses how many pixels the pictures in a headset have, by whether frames come in time: fewer at once where they are
// late, and more step by step. A step that makes frames late is tried again only after a longer time.

const LATE = 1.3;             // of the time between two frames of the headset, from which a frame is late
const LATE_FRAMES = 3;        // late ones in a row, after which there are fewer pixels
const FEWER = 0.85;           // factor of the share
const MORE = 1.05;
const FIRST_PATIENCE = 60;    // frames in time, after which there are more pixels
const MOST_PATIENCE = 3600;
const LEAST_PACE = 0.25;
const FIRST_PACE = 0.7;

export class FramePace {
  // `fixed`: the share; null: as many pixels as come in time.
  /** @param {number} rate frames a second @param {number | null} fixed */
  constructor(rate, fixed = null) {
    this.frameMs = 1000 / rate;
    this.isFixed = fixed !== null;
    this.share = fixed ?? FIRST_PACE;  // of an eye's pixels along a side, in (0, 1]
    this.late = this.inTime = 0;
    this.patience = FIRST_PATIENCE;
  }

  // Notes how long after the last frame this one came.
  /** @param {number} ms */
  note(ms) {
    if (this.isFixed) return;
    const isLate = ms > LATE * this.frameMs;
    this.late = isLate ? this.late + 1 : 0;
    this.inTime = isLate ? 0 : this.inTime + 1;
    if (this.late >= LATE_FRAMES) {
      this.change(FEWER);
      this.patience = Math.min(MOST_PATIENCE, 2 * this.patience);
    } else if (this.inTime >= this.patience) {
      this.change(MORE);
    }
  }

  /** @param {number} factor */
  change(factor) {
    this.share = Math.max(LEAST_PACE, Math.min(1, this.share * factor));
    this.late = this.inTime = 0;
  }
}
