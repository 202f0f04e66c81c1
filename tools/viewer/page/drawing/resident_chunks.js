// SPDX-License-Identifier: GPL-3.0-or-later
// Decides which chunks of a surface are on the GPU: all if they fit, else those that are nearest to the camera, those
// that it sees first. Coarse meshes stand in for the others.
import {poseOf} from '../camera.js';
import {FetchFailure} from '../reading/fetching.js';
import {distanceToBox} from '../reading/chunks.js';
import {loadResidentTiles} from '../reading/model.js';
import {ContextLost} from './gl_objects.js';
import {Pyramid, ballAround} from './pyramid.js';
import {StandIns} from './stand_ins.js';
/** @import {Viewer} from '../viewer.js' */
/** @import {Chunks} from '../reading/chunks.js' */
/** @import {Camera, Chunk, ChunkParts, DrawnChunk, Mesh, Scene} from '../types.d.ts' */

const CHUNKS_AT_ONCE = 6;      // that are fetched at the same time
const GATHERED_AT_ONCE = 256;  // the same, where many come in one answer
const SHARE_OF_TAKING = 3;     // time between two takings of chunks, by the time that one takes
const UNSEEN = 4;              // how much farther a chunk counts that the camera does not see
const CLEARLY_FARTHER = 1.25;  // how much farther a chunk is that gives its room to another
const FOR_STAND_INS = 1 / 4;   // share of the room, where chunks do not fit

export class ResidentChunks {
  // `scene`: that of the chunks.
  /** @param {Viewer} viewer @param {Scene} scene @param {Chunks} chunks */
  constructor(viewer, scene, chunks) {
    this.viewer = viewer;
    this.renderer = viewer.renderer;
    this.scene = scene;
    this.chunks = chunks;
    this.balls = chunks.boxes.map(ballAround);
    this.camera = new Pyramid(viewer.camera());
    this.center = poseOf(viewer.camera()).position;
    /** @type {Map<number, number>} */
    this.there = new Map();    // bytes on the GPU, of the chunks that are drawn
    /** @type {Map<number, ChunkParts>} */
    this.parts = new Map();    // of the chunks that are drawn
    /** @type {Map<string, DrawnChunk>} */
    this.former = new Map();   // chunks of the version before, by the files of their meshes
    /** @type {Set<number>} */
    this.coming = new Set();
    /** @type {Set<number>} */
    this.lost = new Set();     // chunks that could not be fetched and are not asked for until askAgain()
    /** @type {Chunk[]} */
    this.read = [];            // that are drawn from the next take() on
    this.room = Infinity;      // bytes of all that is drawn of the surface, once it is known
    this.roomForStandIns = 0;  // bytes of it
    this.standIns = new StandIns(this.renderer.surface, chunks);
    /** @type {Set<number>} */
    this.standInsComing = new Set();
    /** @type {Set<number>} */
    this.standInsLost = new Set();
    this.taken = {at: -Infinity, ms: 0};
    this.count = 0;            // of the chunks that were taken, again and again
    this.waits = false;        // take() is called from outside alone
    /** @type {Promise<boolean> | null} */
    this.filling = null;
    /** @type {Uint32Array<ArrayBuffer> | null} */
    this.resident = null;      // tiles, as the first chunk says once it was read
    /** @type {() => void} */
    this.noteFirst = () => {};
    /** @type {Promise<void>} */
    this.firstIsRead = new Promise((resolve) => {
      this.noteFirst = resolve;
    });
    /** @type {() => void} */
    this.begin = () => {};
    /** @type {Promise<void>} */
    this.begun = new Promise((resolve) => {  // once a chunk is drawn
      this.begin = resolve;
    });
  }

  // Throws ContextLost where what is on the GPU is not these chunks' any more.
  expect() {
    this.viewer.expect(this.renderer);
    if (!this.waits && this.viewer.chunks !== this) throw new ContextLost();
  }

  // Draws a coarse mesh where chunks are missing.
  /** @param {Mesh} mesh */
  setCoarse(mesh) {
    this.standIns.add(mesh);
    this.drawCoarse();
  }

  // Returns whether all chunks are drawn.
  isWhole() {
    return this.there.size === this.chunks.sources.length;
  }

  // Tries again to fetch the chunks that could not be fetched.
  askAgain() {
    this.lost.clear();
    this.standInsLost.clear();
  }

  // Returns how little a chunk is needed for the camera's picture: its distance, more if the camera does not see it.
  /** @param {number} number */
  distance(number) {
    const {center} = this;
    const ball = this.balls[number];
    const toMiddle = Math.hypot(...ball.center.map((value, axis) => value - center[axis]));
    // Several boxes may hold the camera; the small term then prefers the chunk whose middle is nearest.
    const distance = distanceToBox(this.chunks.boxes[number], center) + 1e-6 * toMiddle;
    return distance * (this.camera.meets(ball) ? 1 : UNSEEN);
  }

  // Returns the next chunk to fetch; -1: there is none, or no room for it.
  next() {
    const {chunks, there, coming, lost} = this;
    const isRead = new Set(this.read.map(({number}) => number));
    const missing = chunks.sources.flatMap((_, number) =>
        there.has(number) || coming.has(number) || lost.has(number) || isRead.has(number) ? [] :
          [{number, distance: this.distance(number)}]);
    if (missing.length === 0) return -1;
    const wanted = missing.reduce((a, b) => b.distance < a.distance ? b : a);
    if (this.fits(wanted)) return wanted.number;
    // The first chunk has the far sphere, and comes even where it is far away.
    return missing[0].number === 0 && this.there.size > 0 ? 0 : -1;
  }

  // Returns whether there is room for a chunk, if those give theirs that are clearly farther.
  /** @param {{number: number, distance: number}} wanted */
  fits({number, distance}) {
    const others = [...this.coming, ...this.read.map((chunk) => chunk.number)];
    let bytes = this.estimate(number) + others.reduce((sum, other) => sum + this.estimate(other), 0);
    for (const [other, taken] of this.there) {
      if (other === 0 || this.distance(other) <= CLEARLY_FARTHER * distance) bytes += taken;
    }
    return bytes <= this.room - this.roomForStandIns;
  }

  // Returns the bytes that a chunk takes on the GPU, estimated by those that are there.
  /** @param {number} number */
  estimate(number) {
    const known = this.there.get(number);
    if (known !== undefined) return known;
    const {bytes} = this.chunks;
    let [onGpu, inFiles] = [0, 0];
    for (const [other, taken] of this.there) [onGpu, inFiles] = [onGpu + taken, inFiles + bytes[other]];
    if (inFiles > 0 && bytes[number] > 0) return bytes[number] * onGpu / inFiles;
    return this.there.size > 0 ? onGpu / this.there.size : 0;
  }

  // Returns the bytes that all chunks would take on the GPU.
  estimateOfAll() {
    return this.chunks.sources.reduce((sum, _, number) => sum + this.estimate(number), 0);
  }

  // Fetches what a camera's picture needs, as far as there is room. Resolves to whether chunks were taken.
  /** @param {Camera} camera */
  provide(camera) {
    this.camera = new Pyramid(camera);
    this.center = poseOf(camera).position;
    this.filling ??= this.fill().finally(() => {
      this.filling = null;
    });
    return this.filling;
  }

  async fill() {
    const before = this.count;
    const length = this.viewer.files.gathering ? GATHERED_AT_ONCE : CHUNKS_AT_ONCE;
    await Promise.all(Array.from({length}, () => this.fetchOthers()));
    this.expect();
    if (this.lost.size + this.standInsLost.size === 0) this.viewer.losses.clearPart('chunk');
    if (!this.waits) this.take();
    return this.count > before;
  }

  // Returns for each tile of the scene 1 or 0: whether it is among the photographs. Throws FetchFailure if the file
  // that says so cannot be fetched.
  async residentTiles() {
    if (this.coming.has(0)) await Promise.race([this.filling, this.firstIsRead]);
    return this.resident ?? loadResidentTiles(this.scene);
  }

  async fetchOthers() {
    for (let number = this.next(); number >= 0; number = this.next()) await this.fetch(number);
    for (let number = this.nextStandIn(); number >= 0 && !this.waits; number = this.nextStandIn()) {
      await this.fetchStandIn(number);
    }
  }

  // Returns how little the mesh is needed that stands in for some chunks; Infinity: all of these are drawn.
  /** @param {number} number */
  distanceOfStandIn(number) {
    const {first, end} = this.chunks.standIns[number];
    let least = Infinity;
    for (let chunk = first; chunk < end; ++chunk) {
      if (!this.there.has(chunk)) least = Math.min(least, this.distance(chunk));
    }
    return least;
  }

  // Returns the next mesh to fetch that stands in for some chunks; -1: there is none, or no room for it.
  nextStandIn() {
    const {standIns, standInsComing, standInsLost} = this;
    if (this.roomForStandIns === 0) return -1;
    const missing = this.chunks.standIns.flatMap((_, number) =>
        standIns.there.has(number) || standInsComing.has(number) || standInsLost.has(number) ? [] :
          [{number, distance: this.distanceOfStandIn(number)}]).filter(({distance}) => distance < Infinity);
    if (missing.length === 0) return -1;
    const {number, distance} = missing.reduce((a, b) => b.distance < a.distance ? b : a);
    const nearer = standIns.numbers().filter((other) => this.distanceOfStandIn(other) <= CLEARLY_FARTHER * distance);
    const bytes = [number, ...standInsComing, ...nearer].reduce((sum, each) => sum + standIns.bytesOf(each), 0);
    return bytes <= this.roomForStandIns ? number : -1;
  }

  /** @param {number} number */
  async fetchStandIn(number) {
    const {standIns, standInsComing, viewer} = this;
    standInsComing.add(number);
    try {
      const mesh = await this.chunks.loadStandIn(number);
      this.expect();
      standIns.add(mesh, number);
    } catch (error) {
      if (!(error instanceof FetchFailure)) throw error;
      this.expect();
      this.standInsLost.add(number);
      if (!viewer.passesBy(error)) viewer.losses.notePart('chunk', error);
    } finally {
      standInsComing.delete(number);
    }
    this.dropStandIns();
    this.drawCoarse();
    viewer.invalidate();
  }

  // Drops the meshes that stand in for no chunk, and the farthest until the others have room.
  dropStandIns() {
    const {standIns} = this;
    const ordered = standIns.numbers().map((number) => ({number, distance: this.distanceOfStandIn(number)}))
        .sort((a, b) => a.distance - b.distance);
    let bytes = 0;
    for (const {number, distance} of ordered) {
      bytes += standIns.bytesOf(number);
      if (distance === Infinity || bytes > this.roomForStandIns) standIns.remove(number);
    }
  }

  // A chunk that cannot be fetched is noted as lost, and others go on.
  /** @param {number} number */
  async fetch(number) {
    const {viewer} = this;
    this.coming.add(number);
    try {
      const chunk = await this.chunks.load(number, this.scene, this.former);
      this.expect();
      this.read.push(chunk);
      if (number === 0) {
        this.resident = chunk.tables.resident;
        this.noteFirst();
      }
    } catch (error) {
      if (!(error instanceof FetchFailure)) throw error;
      this.expect();
      this.lost.add(number);
      if (!viewer.passesBy(error)) viewer.losses.notePart('chunk', error);
    } finally {
      this.coming.delete(number);
    }
    // Depths of photographs are drawn again each time.
    const isTime = performance.now() - this.taken.at > SHARE_OF_TAKING * this.taken.ms;
    if (isTime && !this.waits) this.take();
  }

  // Draws the chunks that were read, in the place of those that are clearly less needed. `gone`: the boxes of chunks
  // that were drawn before.
  /** @param {number[][]} gone */
  take(gone = []) {
    const {surface} = this.renderer;
    const start = performance.now();
    const chunks = this.read.splice(0);
    if (chunks.length + gone.length === 0) return;
    const changed = chunks.filter(({like}) => !like).map(({number}) => number);
    const bytes = chunks.reduce((sum, {number}) => sum + this.estimate(number), 0);
    changed.push(...this.makeRoom(bytes));
    for (const {number, uri, parts, mesh, like, colors, tables} of chunks) {
      // The one that has the mesh may have given its room to another meanwhile; then this one is fetched again.
      if (like && !surface.rename(like.uri, uri)) {
        changed.push(number);
        continue;
      }
      if (mesh) surface.setMesh(uri, mesh);
      if (colors) surface.setColors(uri, colors);
      surface.setTables(uri, tables);
      this.there.set(number, surface.bytesOf(uri));
      this.parts.set(number, parts);
      if (mesh) this.viewer.noteOffset(mesh);
    }
    this.count += chunks.length;
    if (this.room === Infinity) this.takeRoom();
    this.dropStandIns();
    this.drawCoarse();
    const boxes = [...gone, ...changed.map((number) => this.chunks.boxes[number])];
    this.viewer.surfaceChanged(chunks.some(({mesh}) => mesh?.hasFar) ? null : boxes);
    const now = performance.now();
    this.taken = {at: now, ms: now - start};
    this.begin();
  }

  // Shares the memory between chunks and the meshes that stand in for them.
  takeRoom() {
    const all = this.estimateOfAll();
    this.room = this.viewer.roomForChunks(all);
    const isScarce = this.room < all && this.chunks.standIns.length > 0;
    this.roomForStandIns = isScarce ? FOR_STAND_INS * this.room : 0;
  }

  // Drops the chunks that are farthest, until there is room for `bytes`, and returns their numbers.
  /** @param {number} bytes */
  makeRoom(bytes) {
    let taken = [...this.there.values()].reduce((sum, each) => sum + each, 0);
    const farthest = [...this.there.keys()].filter((number) => number !== 0)
        .map((number) => ({number, distance: this.distance(number)})).sort((a, b) => a.distance - b.distance);
    /** @type {number[]} */
    const dropped = [];
    while (taken + bytes > this.room - this.roomForStandIns && farthest.length > 0) {
      const {number} = /** @type {{number: number}} */ (farthest.pop());
      taken -= this.there.get(number) ?? 0;
      this.there.delete(number);
      this.parts.delete(number);
      this.renderer.surface.remove(this.chunks.sources[number].uri);
      dropped.push(number);
    }
    return dropped;
  }

  // The coarse meshes are not needed any more once all chunks are there, because then there is room for all.
  drawCoarse() {
    if (this.isWhole()) {
      this.standIns.removeAll();
    } else if (this.there.size > 0) {
      this.standIns.draw((number) => !this.there.has(number));
    }
  }

  // Keeps the chunks of another version that this one has too, which the GPU has already, and notes the others, whose
  // meshes chunks of this version may have.
  /** @param {ResidentChunks} before */
  keepFrom(before) {
    const numbers = new Map(this.chunks.sources.map(({uri}, number) => [uri, number]));
    for (const [number, bytes] of before.there) {
      const {uri} = before.chunks.sources[number];
      const parts = before.parts.get(number);
      const now = numbers.get(uri);
      if (now !== undefined) {
        this.there.set(now, bytes);
        if (parts) this.parts.set(now, parts);
      } else if (parts) {
        this.former.set(parts.mesh, {...parts, uri, box: before.chunks.boxes[number]});
      }
    }
    // A surface that had room as a whole may have grown.
    const taken = [...before.there.values()].reduce((sum, each) => sum + each, 0);
    if (before.isWhole() && taken <= before.room) return;
    this.room = before.room;
    this.roomForStandIns = before.roomForStandIns;
  }

  // Reads what a camera needs of another version, without drawing it. Resolves to whether all of it could be had.
  /** @param {Camera} camera */
  async stage(camera) {
    this.waits = true;
    await this.provide(camera);
    this.waits = false;
    return this.lost.size === 0;
  }

  // Draws what was staged in the place of all that is of another version.
  /** @param {Mesh | null} coarse */
  replaceAll(coarse) {
    const {surface} = this.renderer;
    // Some may have given their room to others meanwhile.
    for (const number of [...this.there.keys()]) {
      if (surface.pieces.has(this.chunks.sources[number].uri)) continue;
      this.there.delete(number);
      this.parts.delete(number);
    }
    const kept = new Set([...this.there.keys()].map((number) => this.chunks.sources[number].uri));
    for (const {like} of this.read) if (like) kept.add(like.uri);
    surface.removeAllBut(kept);
    const gone = [...this.former.values()].map(({box}) => box);
    this.former.clear();
    if (coarse) this.setCoarse(coarse);
    this.take(gone);
    if (this.there.size > 0) this.takeRoom();
    this.drawCoarse();
  }
}
