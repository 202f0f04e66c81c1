// SPDX-License-Identifier: GPL-3.0-or-later
// The panels beside the picture, each opened and closed by a button; at most one is open.

/**
 * @typedef {{
 *   button: HTMLButtonElement,
 *   panel: HTMLElement,
 *   toggled: (open: boolean) => void,
 * }} Panel
 */

export class Panels {
  constructor() {
    /** @type {Panel[]} */
    this.panels = [];
    addEventListener('keydown', (event) => {
      if (event.key === 'Escape' && !event.defaultPrevented) this.closeAll();
    });
  }

  // Connects a panel with its button and with the button "Close" inside of it. `toggled` is told of each change.
  /** @param {Panel} panel */
  add(panel) {
    this.panels.push(panel);
    panel.button.addEventListener('click', () => this.toggle(panel));
    panel.panel.querySelector('.close')?.addEventListener('click', () => this.close(panel));
  }

  /** @param {Panel} panel */
  toggle(panel) {
    if (!panel.panel.hidden) return this.close(panel);
    this.closeAll();
    panel.panel.hidden = false;
    panel.button.setAttribute('aria-expanded', 'true');
    panel.toggled(true);
  }

  /** @param {Panel} panel */
  close(panel) {
    if (panel.panel.hidden) return;
    if (panel.panel.contains(document.activeElement)) panel.button.focus();
    panel.panel.hidden = true;
    panel.button.setAttribute('aria-expanded', 'false');
    panel.toggled(false);
  }

  closeAll() {
    for (const panel of this.panels) this.close(panel);
  }
}
