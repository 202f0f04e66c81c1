// SPDX-License-Identifier: GPL-3.0-or-later
// Fades the controls out while the visitor only looks, and in again with the first touch. The key H hides them until it
// is pressed again.

const IDLE_MS = 6000;
const USES = ['pointermove', 'pointerdown', 'wheel', 'keydown', 'focusin'];
// What the visitor has opened keeps the controls.
const OPEN = 'dialog[open], :is(.panel, #tools, #comparison, #notice):not([hidden])';

export class QuietControls {
  constructor() {
    this.idleMs = IDLE_MS;
    this.isHeld = false;  // hidden by the key
    this.timer = 0;
    for (const name of USES) addEventListener(name, () => this.used(), {capture: true, passive: true});
    addEventListener('keydown', (event) => {
      const writes = event.target instanceof HTMLElement && event.target.matches('input, textarea, select');
      if (event.code !== 'KeyH' || writes || event.ctrlKey || event.metaKey || event.altKey) return;
      this.isHeld = !this.isHeld;
      this.show(!this.isHeld);
    });
    this.used();
  }

  // Shows the controls, until they have rested.
  used() {
    clearTimeout(this.timer);
    this.timer = setTimeout(() => this.rest(), this.idleMs);
    if (!this.isHeld) this.show(true);
  }

  rest() {
    if (document.querySelector(OPEN)) return this.used();
    this.show(false);
  }

  /** @param {boolean} isShown */
  show(isShown) {
    document.documentElement.classList.toggle('quiet', !isShown);
  }
}
