// SPDX-License-Identifier: GPL-3.0-or-later
// Orders the faces of a mesh so that those that are shown come first in each of its groups.
/** @import {ShownPart} from '../types.d.ts' */

// Sorts the corners within each group, and returns how many of each group are shown: those of faces whose middle
// `isShown` takes.
/**
 * @param {Float32Array} positions
 * @param {Uint32Array} corners
 * @param {number[]} counts
 * @param {ShownPart} isShown
 */
export function sortShown(positions, corners, counts, isShown) {
  let first = 0;
  return counts.map((count) => {
    const hidden = [];
    let end = first;
    for (let i = first; i < first + count; i += 3) {
      const [a, b, c] = [3 * corners[i], 3 * corners[i + 1], 3 * corners[i + 2]];
      const middle = (/** @type {number} */ axis) =>
          (positions[a + axis] + positions[b + axis] + positions[c + axis]) / 3;
      if (isShown(middle(0), middle(1), middle(2))) {
        corners.copyWithin(end, i, i + 3);
        end += 3;
      } else {
        hidden.push(a / 3, b / 3, c / 3);
      }
    }
    corners.set(hidden, end);
    const shown = end - first;
    first += count;
    return shown;
  });
}
