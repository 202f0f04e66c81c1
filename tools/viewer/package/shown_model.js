// SPDX-License-Identifier: GPL-3.0-or-later
// Shows one model in a canvas of an element, from its first request to the end.
import {Drift} from '../page/drift.js';
import {Headset} from '../page/headset/headset.js';
import {interact} from '../page/interaction.js';
import {poseOfSaved} from '../page/owner/owners_views.js';
import {emptyPageFile, shownPart} from '../page/owner/page_file.js';
import {readPageFile} from '../page/owner/read_page_file.js';
import {viewsOf} from '../page/reading/model.js';
import {Viewer, defaultMemory} from '../page/viewer.js';
import {ownersFileOf, partsOfAddress} from './model_address.js';
import {opened} from './opening.js';
import {shaders} from './shaders.js';
import {placeOf, placeOfView} from './view_poses.js';
/** @import {Texts} from '../page/texts/texts.js' */
/** @import {WantedCamera} from './view_poses.js' */
/** @import {PageFile} from '../page/types.d.ts' */

const JUMP_MS = 700;
const UNKNOWN_UNIT = {name: '', length: 1};

// Called with what happens to a model. `failed`: `final` says that the model will not come.
/**
 * @typedef {{
 *   drawn(): void,
 *   moved(): void,
 *   begun(came: number, all: number): void,
 *   progressed(done: number, total: number, ended: boolean): void,
 *   failed(message: string, final: boolean): void,
 *   missing(line: string): void,
 *   headset(shows: boolean): void,
 * }} Listener
 */

const taken = () => new DOMException('the model was taken away before it was there', 'AbortError');
const nextFrame = () => new Promise((resolve) => requestAnimationFrame(resolve));

export class ShownModel {
  // `memory`: MiB; null: the device's default. `owner`: address of the owner's file; null: the one beside the model, if
  // there is one; 'off': none. `drifts`: the camera moves slowly until it is touched.
  /**
   * @param {HTMLCanvasElement} canvas
   * @param {string} source
   * @param {{memory: number | null, owner: string | null, drifts: boolean, texts: Texts}} options
   * @param {Listener} listener
   */
  constructor(canvas, source, {memory, owner, drifts, texts}, listener) {
    this.listener = listener;
    this.drifts = drifts;
    /** @type {Drift | null} */
    this.drift = null;
    const parts = partsOfAddress(source);
    this.viewer = new Viewer(canvas, {...parts, memory: memory ?? defaultMemory(), texels: 'auto', shaders, texts});
    this.mayLackOwner = owner === null;
    this.ownersFile = owner === 'off' ? '' : owner === null ? ownersFileOf(parts.model) :
      new URL(owner, document.baseURI).href;
    this.owner = emptyPageFile();
    this.complaint = '';  // about the owner's file
    this.closed = false;
    /** @type {string[]} */
    this.errors = [];
    /** @type {{jump: object | null, resolve: () => void}[]} */
    this.arrivals = [];  // callers who wait until a jump ends
    this.headset = new Headset(this.viewer, () => this.owner.unit ?? UNKNOWN_UNIT);
    this.headset.changed = () => listener.headset(this.headset.session !== null);
    this.listen();
  }

  listen() {
    const {viewer, listener} = this;
    viewer.changed = () => listener.moved();
    viewer.begun = (came, all) => listener.begun(came, all);
    viewer.progressed = () => {
      const {done, total, ended} = viewer.residents.progress();
      listener.progressed(done, total, ended);
    };
    viewer.missing = (line) => {
      this.errors = [this.complaint, line].filter(Boolean);
      listener.missing(this.errors.join(' '));
      if (line !== '' && !viewer.losses.parts.get('scene')?.final) listener.failed(line, false);
    };
    viewer.gpuLost = (lost) => {
      const line = lost ? viewer.texts.say('gpuLostInElement') : '';
      listener.missing(line);
      if (lost) listener.failed(line, false);
    };
    viewer.failed = (error) => this.fail(error);
  }

  /** @param {Error} error */
  fail(error) {
    if (this.closed) return;
    const line = this.viewer.texts.of(error);
    this.errors = [line];
    this.listener.missing(line);
    this.listener.failed(line, true);
  }

  // Resolves once every file is loaded that the server has. Throws if there is no model, or once it is closed.
  async load() {
    const {viewer, listener} = this;
    try {
      const [said] = await Promise.all([
        readPageFile(viewer.files, this.ownersFile, this.mayLackOwner), opened(viewer),
      ]);
      this.takeOwner(said);
      this.drift = this.drifts ? new Drift(viewer, viewer.canvas) : null;
      interact(viewer, () => {
        this.arrive();
        listener.drawn();
      }, this.drift);
      listener.moved();
      await viewer.load();
    } catch (error) {
      if (this.closed) throw taken();
      this.fail(error instanceof Error ? error : new Error(String(error)));
      throw error;
    }
  }

  // Shows what the owner's file says: the first view, what is up, and the shown part of the surface.
  /** @param {{file: PageFile, complaint: Error | null}} said */
  takeOwner({file, complaint}) {
    const {viewer} = this;
    this.owner = file;
    viewer.navigation.setUp(file.up);
    if (file.view) viewer.navigation.set(poseOfSaved(file.view), file.view.fov);
    const part = shownPart(file);
    if (part) viewer.setShownPart(part, Boolean(file.crop));
    if (!complaint) return;
    this.complaint = viewer.texts.of(complaint);
    viewer.missing(viewer.losses.line());
    this.listener.failed(this.complaint, false);
  }

  // Ends requests and drawing, and gives back what is on the GPU with the context.
  close() {
    if (this.closed) return;
    this.closed = true;
    this.headset.end();
    this.viewer.close();
    this.viewer.gl.getExtension('WEBGL_lose_context')?.loseContext();
    for (const {resolve} of this.arrivals.splice(0)) resolve();
  }

  get names() {
    return this.viewer.model ? viewsOf(this.viewer.scene).map(({name}) => name) : [];
  }

  // Resolves on arrival, or when the visitor goes elsewhere.
  /** @param {string | number | WantedCamera} target @param {number} [duration] */
  goTo(target, duration = JUMP_MS) {
    const {viewer} = this;
    const {navigation, canvas} = viewer;
    const place = typeof target === 'object' ? placeOf(target, navigation) :
        placeOfView(target, navigation, canvas.width, canvas.height);
    navigation.goTo(place.pose, place.fov, duration > 0 ? performance.now() : undefined, duration);
    viewer.moved();
    const {jump} = navigation;
    if (!jump) return Promise.resolve();
    return /** @type {Promise<void>} */ (new Promise((resolve) => this.arrivals.push({jump, resolve})));
  }

  arrive() {
    const {jump} = this.viewer.navigation;
    const arrived = this.arrivals.filter((arrival) => arrival.jump !== jump);
    this.arrivals = this.arrivals.filter((arrival) => arrival.jump === jump);
    for (const {resolve} of arrived) resolve();
  }

  // Waits for frames until `happened()`. Throws AbortError once the model is closed.
  /** @param {() => boolean} happened */
  async until(happened) {
    while (!happened()) {
      await nextFrame();
      if (this.closed) throw taken();
    }
  }

  // Resolves with the still frame as a PNG once it is drawn.
  async screenshot() {
    const {viewer} = this;
    await this.until(() => viewer.still === 'done' && !viewer.stale && !viewer.dirty);
    const blob = await viewer.screenshot();
    if (!blob) throw new Error('the browser makes no file of the picture');
    return blob;
  }

  // Resolves with the share of the picture that was photographed from near there, in [0, 1].
  async coverage() {
    const {viewer} = this;
    await this.until(() => Boolean(viewer.hasMesh && viewer.renderer.ready()));
    if (viewer.dirty || !viewer.drawn) viewer.drawNow();
    const {target, camera} = /** @type {NonNullable<typeof viewer.drawn>} */ (viewer.drawn);
    try {
      return await viewer.renderer.glances.photographedShare(target, camera, camera.width / camera.height);
    } catch (error) {
      throw this.closed ? taken() : error;
    }
  }
}
