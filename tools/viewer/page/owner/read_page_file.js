// SPDX-License-Identifier: GPL-3.0-or-later
// Fetches the owner's file beside a model.
import {FetchFailure} from '../reading/fetching.js';
import {TextError} from '../texts/texts.js';
import {PAGE_FILE_NAME, PageFileError, emptyPageFile, parsePageFile} from './page_file.js';
/** @import {SiteFiles} from '../reading/site_files.js' */

// Returns the owner's file, an empty one where the site has none, and an error that says why it cannot be used; null:
// it can. `mayLack`: the server may have no such file, and says so, or answers with a page of its own.
/** @param {SiteFiles} files @param {string | undefined} name */
export async function readPageFile(files, name, mayLack = false) {
  const file = emptyPageFile();
  if (!name) return {file, complaint: null};
  try {
    const text = await files.read(name, (blob) => blob.text(), true);
    if (mayLack && text.trimStart().startsWith('<')) return {file, complaint: null};
    return {file: parsePageFile(text), complaint: null};
  } catch (error) {
    if (error instanceof PageFileError) return {file, complaint: error};
    if (!(error instanceof FetchFailure)) throw error;
    if (mayLack && error.gone) return {file, complaint: null};
    return {file, complaint: new TextError('pageFileMissing', {file: PAGE_FILE_NAME})};
  }
}
