// SPDX-License-Identifier: GPL-3.0-or-later
// Decides which photographs are on the GPU: all if they fit, else those that the current picture needs. Others stay
// until their place is needed, and are shown where a better one is not there yet.
import {FetchFailure} from '../reading/fetching.js';
import {ContextLost} from './gl_objects.js';
import {loadMask, viewsOf} from '../reading/model.js';
import {Photographs} from './photographs.js';
import {Pyramid, ballAround} from './pyramid.js';
/** @import {Viewer} from '../viewer.js' */
/** @import {Camera, FetchedView, Scene, View} from '../types.d.ts' */

const AT_ONCE = 4;  // views that are fetched at the same time
// A view takes another's cell only where pictures need it CLEARLY times as much, so that a small movement does not
// fetch back what the one before threw away.
const CLEARLY = 1.5;

// The time that views which are there already may take to be renewed, before the next version of a model that changes
// is asked for. Those that are left come with that one, and new photographs before them.
const RENEWING_MS = 500;
const SHARES_ENOUGH = 8;  // of views that the hold takes the median of

// Tells what a view on the GPU is made of besides the surface: its photograph, whose texels have the mask, and for its
// depths the camera too.
/** @param {View} view */
const contentOf = ({photograph, mask, rotation, translation, fx, fy, cx, cy}) =>
    ({photograph, mask, camera: JSON.stringify([rotation, translation, fx, fy, cx, cy])});

// Returns the next view slot to fetch, and in `instead` the slot whose cell it takes if none is free. Null: nothing to
// fetch. `ranked`: all views, those that are needed most first; `held`: slots that have a cell; `fresh`: those of them
// that are as the scene has them; `coming`: slots that are being fetched; `lost`: slots that could not be fetched;
// `room`: the number of cells.
/**
 * @param {{slot: number, need: number}[]} ranked
 * @param {{
 *   held: {has(slot: number): boolean, size: number}, fresh: Set<number>, coming: Set<number>, lost: Set<number>,
 *   room: number,
 * }} state
 * @returns {{slot: number, instead?: number} | null}
 */
function nextToFetch(ranked, {held, fresh, coming, lost, room}) {
  const wanted = ranked.find(({slot}) => !fresh.has(slot) && !coming.has(slot) && !lost.has(slot));
  if (!wanted) return null;
  if (held.has(wanted.slot)) return {slot: wanted.slot};
  const taken = [...coming].filter((slot) => !held.has(slot)).length;
  if (held.size + taken < room) return {slot: wanted.slot};
  // Each of those that are coming takes the room of another one.
  const giving = ranked.filter(({slot}) => held.has(slot)).at(-1 - (held.size + taken - room));
  if (!giving || !(wanted.need > CLEARLY * giving.need)) return null;
  return {slot: wanted.slot, instead: giving.slot};
}

export class Residents {
  /** @param {Viewer} viewer */
  constructor(viewer) {
    this.viewer = viewer;
    /** @type {Map<number, ReturnType<typeof contentOf>>} */
    this.fresh = new Map();  // of what the views on the GPU are made, for each slot
    /** @type {Set<number>} */
    this.stale = new Set();  // views on the GPU that need renewal, those first that have needed it longest
    /** @type {{until: number | null} | null} */
    this.limit = null;       // when no more views are renewed, from the first one on; null: without end
    /** @type {Set<number>} */
    this.coming = new Set();
    /** @type {Set<number>} */
    this.lost = new Set();   // slots that could not be fetched and are not asked for until askAgain()
    /** @type {Map<number, number>} */
    this.needs = new Map();  // for each slot, how many pixels of the current picture need it
    this.fetched = 0;        // views, again and again
    /** @type {Promise<void> | null} */
    this.filling = null;
  }

  // Throws ContextLost where what is on the GPU is not these residents' any more.
  expect() {
    if (this.viewer.residents !== this || this.viewer.gl.isContextLost()) throw new ContextLost();
  }

  get photographs() {
    const {photographs} = this.viewer.renderer;
    if (!photographs) throw new Error('there is no room for photographs yet');
    return photographs;
  }

  // Returns whether there are fewer places than views.
  scarce() {
    return viewsOf(this.viewer.scene).length > this.photographs.layout.count;
  }

  // Forgets all views on the GPU.
  forget() {
    this.fresh.clear();
    this.stale.clear();
  }

  // Notes that depths of views are drawn again, because the surface has changed: of those that may see one of `boxes`;
  // null: of all.
  /** @param {number[][] | null} boxes */
  surfaceChanged(boxes) {
    const {renderer, scene} = this.viewer;
    const balls = boxes?.map(ballAround);
    for (const slot of renderer.photographs?.cells.keys() ?? []) {
      const view = scene.views[slot];
      if (!view) continue;
      const pyramid = new Pyramid(view);
      if (!balls || balls.some((ball) => pyramid.meets(ball))) this.stale.add(slot);
    }
  }

  // Tries again to fetch the views that could not be fetched.
  askAgain() {
    this.lost.clear();
  }

  ranked() {
    const {needs} = this;
    return this.viewer.navigation.viewsByDistance().map((slot) => ({slot, need: needs.get(slot) ?? 0}))
        .sort((a, b) => b.need - a.need);
  }

  // Slots of the photographs that are on the GPU as the scene has them.
  current() {
    const {views} = this.viewer.scene;
    const there = [...this.photographs.cells.keys()];
    return new Set(there.filter((slot) => {
      const view = views[slot];
      return view && this.fresh.get(slot)?.photograph === view.photograph;
    }));
  }

  // Returns what to fetch next: another view, the photograph of one that is there whose mask is another, or the mask
  // alone for its new depths; null: nothing. Of a model that changes, new photographs come first.
  /** @returns {{slot: number, instead?: number, renews?: 'photograph' | 'depths'} | null} */
  next() {
    const fresh = this.current();
    const view = () => nextToFetch(this.ranked(), {
      held: this.photographs.cells, fresh, coming: this.coming, lost: this.lost, room: this.photographs.layout.count,
    });
    return this.viewer.live ? view() ?? this.nextToRenew(fresh) : this.nextToRenew(fresh) ?? view();
  }

  // Returns a view of those in `fresh` that needs renewal; null: none.
  /** @param {Set<number>} fresh @returns {{slot: number, renews: 'photograph' | 'depths'} | null} */
  nextToRenew(fresh) {
    const {views} = this.viewer.scene;
    for (const slot of fresh) {
      const [view, content] = [views[slot], this.fresh.get(slot)];
      if (view && content && (content.mask !== view.mask || content.camera !== contentOf(view).camera)) {
        this.stale.add(slot);
      }
    }
    for (const slot of this.stale) {
      // Others are fetched as a whole.
      if (!fresh.has(slot)) {
        this.stale.delete(slot);
      } else if (!this.coming.has(slot) && !this.lost.has(slot)) {
        return {slot, renews: this.fresh.get(slot)?.mask === views[slot]?.mask ? 'depths' : 'photograph'};
      }
    }
    return null;
  }

  // The same within the time in which views may be renewed.
  nextInTime() {
    const next = this.next();
    if (!next?.renews || !this.limit) return next;
    this.limit.until ??= performance.now() + RENEWING_MS;
    return performance.now() > this.limit.until ? null : next;
  }

  // From now on views are renewed for a short time, until this is called again; without end if not `isLimited`.
  /** @param {boolean} isLimited */
  limitRenewals(isLimited) {
    this.limit = isLimited ? {until: null} : null;
  }

  // Loads what a camera's picture needs, as far as there is room.
  /** @param {Camera} camera */
  async provide(camera) {
    if (this.scarce()) this.needs = await this.viewer.renderer.glances.neededViews(camera);
    await this.fill();
  }

  async fill() {
    for (this.expect(); this.filling || this.nextInTime(); this.expect()) {
      this.filling ??= this.fetchAll().finally(() => {
        this.filling = null;
      });
      await this.filling;
    }
    this.viewer.progressed();
  }

  async fetchAll() {
    await Promise.all(Array.from({length: AT_ONCE}, () => this.fetchOthers()));
    this.expect();
    this.photographs.rest(this.viewer.renderer);
  }

  async fetchOthers() {
    for (let next = this.nextInTime(); next; next = this.nextInTime()) await this.fetch(next.slot, next.renews);
  }

  // A view that cannot be fetched is noted as lost, and others go on. `renews`: what of a view that is there.
  /** @param {number} slot @param {'photograph' | 'depths'} [renews] */
  async fetch(slot, renews) {
    const {viewer, coming} = this;
    const {scene, losses} = viewer;
    const described = scene.views[slot];
    if (!described) return;
    coming.add(slot);
    try {
      if (renews === 'depths') {
        await this.renewDepths(slot, described, scene);
      } else {
        const view = await Photographs.fetched(viewer.files, described, slot);
        this.expect();
        ++this.fetched;
        losses.clearView(slot);
        this.store(view, scene);
      }
    } catch (error) {
      if (!(error instanceof FetchFailure)) throw error;
      if (scene !== viewer.scene) return;  // another version has come meanwhile
      this.lost.add(slot);
      if (!viewer.passesBy(error)) losses.noteView(slot, error);
    } finally {
      coming.delete(slot);
    }
    viewer.progressed();
  }

  // Unless the visitor has gone elsewhere meanwhile, where something else is needed more, or the scene has changed.
  /** @param {FetchedView} view @param {Scene} scene */
  store(view, scene) {
    const {viewer} = this;
    const {renderer} = viewer;
    const {slot} = view;
    const described = scene.views[slot];
    const next = scene === viewer.scene ? this.roomFor(slot) : null;
    if (!next || !described) {
      view.picture.close();
      view.mask?.close();
      return;
    }
    this.stale.delete(slot);
    this.photographs.store(view, renderer, next.instead);
    if (next.instead !== undefined) this.fresh.delete(next.instead);
    this.fresh.set(slot, contentOf(described));
    this.noteOwnShare(slot, described);
    viewer.improve();
  }

  /** @param {number} slot @param {View} view @param {Scene} scene */
  async renewDepths(slot, view, scene) {
    const {viewer} = this;
    const mask = await loadMask(viewer.files, view);
    this.expect();
    // The view may have gone meanwhile, or another version may have come.
    if (scene === viewer.scene && this.photographs.cells.has(slot)) {
      this.stale.delete(slot);
      this.fresh.set(slot, contentOf(view));
      this.photographs.storeDepths(slot, mask, viewer.renderer);
      this.noteOwnShare(slot, view);
      viewer.improve();
    }
    mask?.close();
  }

  // Tells the hold how much of a view's own picture is photographed. It takes as long as the view's depths, so that a
  // model that changes, whose depths are new all the time, has a few views alone told.
  /** @param {number} slot @param {View} view */
  noteOwnShare(slot, view) {
    const {viewer} = this;
    const {own} = viewer.navigation.hold;
    if (viewer.live && own.size >= SHARES_ENOUGH && !own.has(slot)) return;
    viewer.quietly(this.measureOwnShare(slot, view));
  }

  /** @param {number} slot @param {View} view */
  async measureOwnShare(slot, view) {
    const share = await this.viewer.renderer.glances.photographedShareOfView(view);
    this.expect();
    this.viewer.navigation.hold.setOwn(slot, share);
  }

  /** @param {number} slot */
  roomFor(slot) {
    const {cells, layout} = this.photographs;
    const ranked = this.ranked();
    const fresh = new Set(ranked.map((view) => view.slot).filter((other) => other !== slot));
    return nextToFetch(ranked, {held: cells, fresh, coming: new Set(), lost: new Set(), room: layout.count});
  }

  // Counts the views that are there, of those that there is room for. `ended`: the others are not being fetched.
  progress() {
    const total = Math.min(viewsOf(this.viewer.scene).length, this.photographs.layout.count);
    const done = Math.max(0, Math.min(this.current().size, total - this.coming.size));
    return {done, total, ended: done + this.lost.size >= total};
  }
}
