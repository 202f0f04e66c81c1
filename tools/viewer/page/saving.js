// SPDX-License-Identifier: GPL-3.0-or-later
// Hands files to the visitor.

const REVOKE_AFTER_MS = 1000;

// Downloads a file under a name; null: there is none.
/** @param {Blob | null} blob @param {string} name */
export function save(blob, name) {
  if (!blob) return;
  const link = document.createElement('a');
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), REVOKE_AFTER_MS);
}
