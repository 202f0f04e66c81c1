// SPDX-License-Identifier: GPL-3.0-or-later
// The site's files: beside the page on a server, or inside of it (site.cpp, write_one_page).

export class MissingFile extends Error {}

export class SiteFiles {
  // `base`: the address of the folder that they are in.
  constructor(base) {
    this.base = base;
    this.bytes = 0;  // that have come so far
    this.inside = new Map();
    for (const element of document.querySelectorAll('script[data-file]')) {
      this.inside.set(element.dataset.file, element);
    }
  }

  async blob(name) {
    const element = this.inside.get(name);
    const blob = element ? blobOf(element) : await this.fetched(name);
    this.bytes += blob.size;
    return blob;
  }

  async fetched(name) {
    const response = await fetch(new URL(name, this.base));
    if (!response.ok) throw new MissingFile(`${name} cannot be loaded: the server says ${response.status}`);
    return response.blob();
  }

  async array(name) {
    return new Uint8Array(await (await this.blob(name)).arrayBuffer());
  }

  async json(name) {
    return JSON.parse(await (await this.blob(name)).text());
  }

  // For an <img>; inside of a page as a data address, which needs no memory of its own until it is shown.
  address(name) {
    const element = this.inside.get(name);
    return element ? `data:${element.dataset.type};base64,${element.textContent}` : new URL(name, this.base).href;
  }
}

function blobOf(element) {
  const text = atob(element.textContent);
  const bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; ++i) bytes[i] = text.charCodeAt(i);
  return new Blob([bytes], {type: element.dataset.type});
}
