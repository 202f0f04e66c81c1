// SPDX-License-Identifier: GPL-3.0-or-later
// Adds a model to a three.js scene. Each picture of it is drawn into textures with three's context, and these are laid
// into three's picture with the depth of the surface.
import {Object3D} from 'three';
import {viewsOf} from '../page/reading/model.js';
import {Viewer, defaultMemory} from '../page/viewer.js';
import {BorrowedContext} from './borrowed_context.js';
import {partsOfAddress} from './model_address.js';
import {opened} from './opening.js';
import {shaders} from './shaders.js';
import {evenScale, pinholeOf, placeCamera, poseIn} from './three_camera.js';
import {ThreeLayer} from './three_layer.js';
import {placeOfView} from './view_poses.js';
/** @import {Camera, PerspectiveCamera, WebGLRenderer} from 'three' */
/** @import {ViewerOptions} from '../page/types.d.ts' */

// A viewer whose canvas, camera and frames are three's.
class SharedViewer extends Viewer {
  /** @param {HTMLCanvasElement} canvas @param {ViewerOptions} options @param {() => void} renewed */
  constructor(canvas, options, renewed) {
    super(canvas, options);
    this.renewed = renewed;
  }

  // The canvas has the size that three gave it.
  resize() {}

  invalidate() {
    super.invalidate();
    this.renewed();
  }

  improve() {
    this.invalidate();
  }

  // Loads what the present picture needs. Nothing holds three's camera near photographs.
  async look() {
    if (this.looking || !this.drawn) return;
    this.looking = true;
    try {
      await this.provide(this.drawn.camera);
    } finally {
      this.looking = false;
    }
  }
}

/** @typedef {{memory?: number, signal?: AbortSignal, progress?: (done: number, total: number) => void}} LoadOptions */

export class LumatlasObject extends Object3D {
  // Resolves once the surface is there; photographs come afterwards. Throws if the model cannot be had.
  /** @param {string} source @param {WebGLRenderer} renderer @param {LoadOptions} options */
  static async load(source, renderer, options = {}) {
    const object = new LumatlasObject(source, renderer, options);
    try {
      await object._open();
    } catch (error) {
      object.dispose();
      throw error;
    }
    return object;
  }

  /** @param {string} source @param {WebGLRenderer} renderer @param {LoadOptions} options */
  constructor(source, renderer, {memory = defaultMemory(), signal, progress}) {
    super();
    if (renderer.capabilities.reversedDepthBuffer) {
      throw new TypeError('a LumatlasObject needs a renderer without reversedDepthBuffer');
    }
    this.isLumatlasObject = true;
    this.resolution = 1;
    this.far = true;
    /** @type {string[]} */
    this.errors = [];
    /** @type {Promise<void>} */
    this.loaded = Promise.resolve();
    this._renderer = renderer;
    this._context = new BorrowedContext(renderer);
    const options = {
      ...partsOfAddress(source), memory, texels: 'auto', shaders, signal, gl: this._context.gl,
    };
    this._seen = () => {};  // told once there is a surface
    const viewer = new SharedViewer(renderer.domElement, options, () => this._renewed());
    viewer.progressed = () => {
      const {done, total} = viewer.residents.progress();
      progress?.(done, total);
    };
    viewer.missing = (line) => {
      this.errors = line === '' ? [] : [line];
    };
    viewer.failed = (error) => this._fail(error.message);
    this._viewer = viewer;
    this._layer = new ThreeLayer((camera) => this._draw(camera));
    this._drawnFor = '';
    this.add(this._layer.mesh);
  }

  async _open() {
    const viewer = this._viewer;
    await opened(viewer);
    const seen = /** @type {Promise<void>} */ (new Promise((resolve) => {
      this._seen = resolve;
    }));
    this.loaded = viewer.load();
    this.loaded.catch((error) => {
      if (!viewer.closing.signal.aborted) this._fail(String(error.message ?? error));
    });
    await Promise.race([this.loaded, seen]);
  }

  _renewed() {
    if (this._viewer?.hasMesh) this._seen();
    this.dispatchEvent(/** @type {never} */ ({type: 'change'}));
  }

  // Names of the model's photographs.
  get views() {
    return viewsOf(this._viewer.scene).map(({name}) => name);
  }

  // The upward direction of the model, in the object's own coordinates: x, y, z.
  get modelUp() {
    return [...this._viewer.navigation.up];
  }

  // Puts a camera where a photograph was taken, by its name or number, so that its picture shows all of it. The
  // object's world matrix must be up to date. Throws RangeError if there is no such photograph.
  /** @param {PerspectiveCamera} camera @param {string | number} view */
  placeCamera(camera, view = this._viewer.scene.first_view) {
    const {pose, fov} = placeOfView(view, this._viewer.navigation, camera.aspect, 1);
    placeCamera(camera, this, pose, fov);
  }

  // Ends requests, and deletes what is on the GPU.
  dispose() {
    this.removeFromParent();
    this._context.during(() => this._viewer.close());
    this._layer.dispose(this._renderer);
  }

  // Before three draws the layer: makes the picture of that camera anew, unless it is as it was.
  /** @param {Camera} camera */
  _draw(camera) {
    const {_layer: layer, _viewer: viewer} = this;
    layer.hide();
    if (!viewer.hasMesh || viewer.gl.isContextLost()) return;
    try {
      this._drawFor(this._checked(camera));
    } catch (error) {
      if (!viewer.isOfLostGpu(error)) this._fail(error instanceof Error ? error.message : String(error));
    }
  }

  /** @param {Camera} camera @returns {PerspectiveCamera} */
  _checked(camera) {
    if (!('isPerspectiveCamera' in camera)) throw new TypeError('a LumatlasObject needs a perspective camera');
    if (this._renderer.xr.isPresenting) throw new TypeError('a LumatlasObject is not drawn in WebXR');
    return /** @type {PerspectiveCamera} */ (camera);
  }

  /** @param {PerspectiveCamera} camera */
  _drawFor(camera) {
    const {_layer: layer, _viewer: viewer, _renderer: renderer} = this;
    const unit = evenScale(this);
    const viewport = layer.viewportOf(renderer);
    const [width, height] = [viewport.z, viewport.w].map((side) => Math.max(1, Math.round(side * this.resolution)));
    const pose = poseIn(camera, this);
    const pinhole = pinholeOf(camera, pose, width, height);
    const drawnFor = JSON.stringify(pinhole);
    if (viewer.dirty || !viewer.drawn || drawnFor !== this._drawnFor) {
      viewer.navigation.set(pose, 2 * Math.atan(height / 2 / pinhole.fy) * 180 / Math.PI);
      this._context.during(() => viewer.drawTarget(pinhole));
      this._drawnFor = drawnFor;
    }
    const {target} = /** @type {NonNullable<typeof viewer.drawn>} */ (viewer.drawn);
    layer.show(renderer, target, {
      camera, unit, far: this.far, depthBeforeFar: viewer.renderer.scene.depth_before_far,
    });
  }

  // Tells of each error once.
  /** @param {string} message */
  _fail(message) {
    if (this.errors.includes(message)) return;
    this.errors = [message];
    console.error(`lumatlas: ${message}`);
  }
}
