// SPDX-License-Identifier: GPL-3.0-or-later
// Owners of what is on the GPU. No other module creates or deletes an object of WebGL.

// The browser has taken the GPU away: all that was on it is gone.
export class ContextLost extends Error {
  constructor() {
    super('the browser has taken the GPU away');
  }
}

// Objects that live together: release() deletes all that were made here.
export class GlObjects {
  /** @param {WebGL2RenderingContext} gl */
  constructor(gl) {
    this.gl = gl;
    /** @type {(() => void)[]} */
    this.deletions = [];
  }

  texture() {
    const texture = this.gl.createTexture();
    this.deletions.push(() => this.gl.deleteTexture(texture));
    return texture;
  }

  buffer() {
    const buffer = this.gl.createBuffer();
    this.deletions.push(() => this.gl.deleteBuffer(buffer));
    return buffer;
  }

  vertexArray() {
    const vertexArray = this.gl.createVertexArray();
    this.deletions.push(() => this.gl.deleteVertexArray(vertexArray));
    return vertexArray;
  }

  renderbuffer() {
    const renderbuffer = this.gl.createRenderbuffer();
    this.deletions.push(() => this.gl.deleteRenderbuffer(renderbuffer));
    return renderbuffer;
  }

  // Bound, with textures as its colours.
  /** @param {WebGLTexture[]} colours */
  framebuffer(...colours) {
    const {gl} = this;
    const framebuffer = gl.createFramebuffer();
    this.deletions.push(() => gl.deleteFramebuffer(framebuffer));
    gl.bindFramebuffer(gl.FRAMEBUFFER, framebuffer);
    colours.forEach((texture, i) => {
      gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0 + i, gl.TEXTURE_2D, texture, 0);
    });
    if (colours.length > 1) gl.drawBuffers(colours.map((_, i) => gl.COLOR_ATTACHMENT0 + i));
    return framebuffer;
  }

  program() {
    const program = this.gl.createProgram();
    this.deletions.push(() => this.gl.deleteProgram(program));
    return program;
  }

  // A shader that is compiled and part of a program, and lives as long as that. Returns it, for its log.
  /** @param {WebGLProgram} program @param {number} type @param {string} source */
  shader(program, type, source) {
    const {gl} = this;
    const shader = gl.createShader(type);
    if (!shader) throw new ContextLost();
    gl.shaderSource(shader, source);
    gl.compileShader(shader);
    gl.attachShader(program, shader);
    gl.deleteShader(shader);  // which happens once its program is deleted
    return shader;
  }

  release() {
    for (const deletion of this.deletions.splice(0)) deletion();
  }
}

// Tells whether the GPU has finished the work that was given to it before the fence was made.
export class Fence {
  /** @param {WebGL2RenderingContext} gl */
  constructor(gl) {
    this.gl = gl;
    this.sync = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
    gl.flush();
  }

  // Once it has passed, nothing is left of it. Throws ContextLost.
  passed() {
    const {gl, sync} = this;
    if (!sync || gl.isContextLost()) throw new ContextLost();
    if (gl.clientWaitSync(sync, gl.SYNC_FLUSH_COMMANDS_BIT, 0) === gl.TIMEOUT_EXPIRED) return false;
    this.release();
    return true;
  }

  release() {
    this.gl.deleteSync(this.sync);
    this.sync = null;
  }
}

/**
 * @typedef {{width: number, height: number, bytes: number}} Sized
 * @typedef {Sized & {pass: WebGLFramebuffer, surface?: WebGLTexture}} SurfaceTarget
 * @typedef {SurfaceTarget & {surface: WebGLTexture, colour: WebGLTexture, blend: WebGLFramebuffer}} PictureTarget
 */

// Render targets, one for each use; made anew if the size has changed.
export class Targets {
  // `changed` is called after each that is made.
  /** @param {WebGL2RenderingContext} gl @param {() => void} changed */
  constructor(gl, changed) {
    this.gl = gl;
    this.changed = changed;
    /** @type {Map<string, {objects: GlObjects, target: Sized}>} */
    this.byUse = new Map();
  }

  // The target of a use; what it was before is gone if it had another size.
  /**
   * @template {object} T
   * @param {string} use
   * @param {number} width
   * @param {number} height
   * @param {number} pixelBytes
   * @param {(objects: GlObjects) => T} make
   * @returns {T & Sized}
   */
  of(use, width, height, pixelBytes, make) {
    const known = this.byUse.get(use);
    if (known && known.target.width === width && known.target.height === height) {
      return /** @type {T & Sized} */ (known.target);
    }
    this.drop(use);
    const objects = new GlObjects(this.gl);
    const target = {width, height, bytes: pixelBytes * width * height, ...make(objects)};
    this.byUse.set(use, {objects, target});
    this.changed();
    return target;
  }

  /** @param {string} use */
  get(use) {
    return this.byUse.get(use)?.target;
  }

  // Returns whether a target is still there, and was not made anew in another size.
  /** @param {Sized} target */
  has(target) {
    return [...this.byUse.values()].some((known) => known.target === target);
  }

  /** @param {string} use */
  drop(use) {
    this.byUse.get(use)?.objects.release();
    this.byUse.delete(use);
  }

  bytes() {
    let sum = 0;
    for (const {target} of this.byUse.values()) sum += target.bytes;
    return sum;
  }

  release() {
    for (const use of [...this.byUse.keys()]) this.drop(use);
  }
}
