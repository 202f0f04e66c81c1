// SPDX-License-Identifier: GPL-3.0-or-later
// Finds the elements of index.html by their ids, and makes others.

// Throws if the page has no such element.
/**
 * @template {HTMLElement} T
 * @param {string} id
 * @param {new () => T} type
 * @returns {T}
 */
export function element(id, type) {
  const found = document.getElementById(id);
  if (!(found instanceof type)) throw new Error(`the page has no ${type.name} "${id}"`);
  return found;
}

/** @param {string} id */
export const button = (id) => element(id, HTMLButtonElement);
/** @param {string} id */
export const part = (id) => element(id, HTMLElement);

// Returns a line of the drawing that lies over the picture.
/** @param {string} id */
export function pathElement(id) {
  const found = document.getElementById(id);
  if (!(found instanceof SVGPathElement)) throw new Error(`the page has no line "${id}"`);
  return found;
}

// Returns a new button. `label` says to screen readers what it does.
/** @param {string} text @param {() => void} clicked */
export function actionButton(text, clicked, label = text) {
  const made = document.createElement('button');
  made.textContent = text;
  made.setAttribute('aria-label', label);
  made.addEventListener('click', clicked);
  return made;
}
