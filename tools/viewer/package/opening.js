// SPDX-License-Identifier: GPL-3.0-or-later
// Opens a model for a caller who waits for it.
/** @import {Viewer} from '../page/viewer.js' */

// Opens a viewer's model. Throws once the server says for good that there is none; the viewer itself would ask again
// and again.
/** @param {Viewer} viewer */
export async function opened(viewer) {
  const {missing} = viewer;
  const refused = /** @type {Promise<never>} */ (new Promise((_, reject) => {
    viewer.missing = (line) => {
      missing(line);
      const failure = viewer.losses.parts.get('scene');
      if (failure?.final) reject(failure);
    };
  }));
  await Promise.race([viewer.open(), refused]);
  viewer.missing = missing;
}
