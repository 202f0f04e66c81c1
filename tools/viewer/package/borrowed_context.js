// SPDX-License-Identifier: GPL-3.0-or-later
// Lends the WebGL context of a three.js renderer to the viewer, between and inside of three's frames. three remembers
// the state that it has set, so the context is given back in the state that three expects.
/** @import {WebGLRenderer, WebGLRenderTarget} from 'three' */

// Calls that change no state that three remembers.
const HARMLESS = /^(get|is|create|client|fence|flush$|compile|link|attach|shaderSource$|deleteSync$|deleteShader$)/;

export class BorrowedContext {
  /** @param {WebGLRenderer} renderer */
  constructor(renderer) {
    this.renderer = renderer;
    this.own = /** @type {WebGL2RenderingContext} */ (renderer.getContext());
    /** @type {{target: WebGLRenderTarget | null, face: number, level: number} | null} */
    this.before = null;  // three's render target, while the context is borrowed
    this.gl = this.wrapped();
  }

  // Returns the context for the viewer. A call that changes state borrows the context until the present task is done.
  // It is without EXT_clip_control, which three sets once, if at all, and does not set again.
  wrapped() {
    const {own} = this;
    /** @type {Map<string | symbol, Function>} */
    const calls = new Map();
    calls.set('getExtension', (/** @type {string} */ name) =>
      name === 'EXT_clip_control' ? null : own.getExtension(name));
    return new Proxy(own, {
      get: (_, name) => {
        const known = calls.get(name);
        if (known) return known;
        const value = Reflect.get(own, name, own);
        if (typeof value !== 'function') return value;
        const harmless = typeof name === 'string' && HARMLESS.test(name);
        const call = harmless ? value.bind(own) : (/** @type {unknown[]} */ ...given) => {
          if (!this.before) this.borrowForTask();
          return value.apply(own, given);
        };
        calls.set(name, call);
        return call;
      },
    });
  }

  borrowForTask() {
    this.borrow();
    queueMicrotask(() => this.giveBack());
  }

  borrow() {
    const {renderer} = this;
    this.before = {
      target: renderer.getRenderTarget(), face: renderer.getActiveCubeFace(), level: renderer.getActiveMipmapLevel(),
    };
    renderer.resetState();
  }

  giveBack() {
    const {before, own, renderer} = this;
    if (!before) return;
    this.before = null;
    own.bindVertexArray(null);
    renderer.resetState();
    renderer.setRenderTarget(before.target, before.face, before.level);
  }

  // Borrows the context for what `draw` does, and for no longer.
  /** @template T @param {() => T} draw @returns {T} */
  during(draw) {
    if (!this.before) this.borrow();
    try {
      return draw();
    } finally {
      this.giveBack();
    }
  }
}
