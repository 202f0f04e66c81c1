// SPDX-License-Identifier: GPL-3.0-or-later
// Fills in the texts of index.html: data-text names an element's content, data-label what screen readers say, data-tip
// what a resting mouse shows.
/** @import {SaidKey} from '../types.d.ts' */
/** @import {Texts} from './texts.js' */

// Puts a text into an element. What is to be typed stands between ` and `.
/** @param {HTMLElement} element @param {string} text */
export function putText(element, text) {
  const parts = text.split('`').map((words, i) => {
    if (i % 2 === 0) return document.createTextNode(words);
    const shown = document.createElement('code');
    shown.textContent = words;
    return shown;
  });
  element.replaceChildren(...parts);
}

/** @param {Texts} texts */
export function fillTexts(texts) {
  document.documentElement.lang = texts.language;
  /** @type {NodeListOf<HTMLElement>} */
  const elements = document.querySelectorAll('[data-text], [data-label], [data-tip]');
  for (const element of elements) {
    const {text, label, tip} = element.dataset;
    if (text) putText(element, texts.say(/** @type {SaidKey} */ (text)));
    if (label) element.setAttribute('aria-label', texts.say(/** @type {SaidKey} */ (label)));
    if (tip) element.title = texts.say(/** @type {SaidKey} */ (tip));
  }
}
