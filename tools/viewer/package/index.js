// SPDX-License-Identifier: GPL-3.0-or-later
// Defines the element <lumatlas-viewer>.
import {LumatlasViewerElement} from './element.js';

export {LumatlasViewerElement};

// A page may hold two copies of this module; the first defines the element. There is no registry outside of browsers.
if (globalThis.customElements && !customElements.get('lumatlas-viewer')) {
  customElements.define('lumatlas-viewer', LumatlasViewerElement);
}
