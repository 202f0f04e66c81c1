// SPDX-License-Identifier: GPL-3.0-or-later
// Finds the elements of index.html by their ids.

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
