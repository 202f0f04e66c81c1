// SPDX-License-Identifier: GPL-3.0-or-later
// Fetches the owner's file beside a model.
import {FetchFailure} from '../reading/fetching.js';
import {PAGE_FILE_NAME, PageFileError, emptyPageFile, parsePageFile} from './page_file.js';
/** @import {SiteFiles} from '../reading/site_files.js' */

// Returns the owner's file, an empty one where the site has none, and one sentence that says why it cannot be used;
// '': it can. `mayLack`: the server may have no such file, and says so, or answers with a page of its own.
/** @param {SiteFiles} files @param {string | undefined} name */
export async function readPageFile(files, name, mayLack = false) {
  const file = emptyPageFile();
  if (!name) return {file, complaint: ''};
  try {
    const text = await files.read(name, (blob) => blob.text(), true);
    if (mayLack && text.trimStart().startsWith('<')) return {file, complaint: ''};
    return {file: parsePageFile(text), complaint: ''};
  } catch (error) {
    if (error instanceof PageFileError) return {file, complaint: error.message};
    if (!(error instanceof FetchFailure)) throw error;
    if (mayLack && error.gone) return {file, complaint: ''};
    return {file, complaint: `${PAGE_FILE_NAME} cannot be loaded: title and annotations are missing.`};
  }
}
