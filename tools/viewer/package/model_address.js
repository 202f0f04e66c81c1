// SPDX-License-Identifier: GPL-3.0-or-later
// Reads addresses of models: of a folder, of its tileset, or of a .glb.

// Returns the folder of a model's files and the name of its first file there. `source` may be relative to the page. A
// name that does not end in .glb or .json is a folder's.
/** @param {string} source @returns {{base: string, model: string}} */
export function partsOfAddress(source) {
  const address = new URL(source, document.baseURI);
  const name = address.pathname.split('/').at(-1) ?? '';
  if (/\.(glb|json)$/i.test(name)) return {base: new URL('.', address).href, model: name};
  if (name !== '') address.pathname += '/';
  return {base: new URL('.', address).href, model: 'tileset.json'};
}

// Returns the name of the owner's file of a model, relative to its folder: page.json, or of NAME.glb NAME.page.json.
/** @param {string} model */
export const ownersFileOf = (model) => /\.glb$/i.test(model) ? `${model.slice(0, -4)}.page.json` : 'page.json';
