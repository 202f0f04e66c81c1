// SPDX-License-Identifier: GPL-3.0-or-later
// Shows a site's model in a canvas: fetches it, draws what its camera sees, and keeps it after a loss of the network or
// of the GPU.
import {MODES} from './address.js';
import {cameraAt, lookingAlong} from './camera.js';
import {FetchFailure} from './reading/fetching.js';
import {ContextLost, Fence} from './drawing/gl_objects.js';
import {makeLayout} from './drawing/layout.js';
import {Losses} from './reading/losses.js';
import {loadColors, loadMesh, loadScene, loadShaders, loadTables, viewsOf, withAllViews} from './reading/model.js';
import {Navigation} from './navigation.js';
import {PLAIN, texelForm} from './drawing/photograph_forms.js';
import {Photographs} from './drawing/photographs.js';
import {PictureSizes} from './drawing/picture_sizes.js';
import {Renderer, partsOf} from './drawing/renderer.js';
import {ResidentChunks} from './drawing/resident_chunks.js';
import {Residents} from './drawing/residents.js';
import {SiteFiles} from './reading/site_files.js';
import {ENGLISH, TextError} from './texts/texts.js';
/** @import {Chunks} from './reading/chunks.js' */
/** @import {LossPart} from './reading/losses.js' */
/** @import {PictureTarget} from './drawing/gl_objects.js' */
/** @import {Picture} from './drawing/surroundings.js' */
/**
 * @import {
 *   Background, Camera, Layout, LiveState, Mesh, MeshFile, Mode, Overrun, Pose, Scene, Shaders, ShownPart, Size,
 *   Tables, TexelForm, Vector, ViewerOptions
 * } from './types.d.ts'
 */

// The work that was given to the GPU.
/** @typedef {{pixels: number, of: 'frame' | 'surface' | 'part' | 'whole' | 'nothing'}} Work */

export const MEBIBYTE = 1 << 20;
const LEAST_FOR_PHOTOGRAPHS = MEBIBYTE / 8;  // share of each mebibyte
const SLOW_VERSION_MS = 1000;
const ASK_AGAIN_MS = 300;  // how often to ask for a new version of a model that changes
const BACK_AGAIN_MS = 50;   // how often to look whether the GPU is back
const STILL_AFTER_MS = 250;
const PRESENT_MS = 250;     // after which new parts of a still frame are shown
const MESH = 'mesh';         // the name of a surface in one piece
const MOST_FOR_CHUNKS = 1 / 2;  // share of what pictures do not take
const CHUNKS_VARY = 1.25;    // from the first of them
const PROGRAMS_MS = 100;    // after which programs may have been compiled
const FIELD_OF_VIEW = 50;   // degrees
const RAY_FOV = 1;          // degrees of the one pixel that looks along a ray
const PHONE_MIB = 100;      // GPU memory that a phone gives a page without closing others
const DESKTOP_MIB = 200;
const LIVE_MIB = 400;       // the same for a model that changes, whose photographs are not compressed
const MOST_PLAIN = 1 / 2;   // share of the memory, for photographs that are not compressed

// MiB that a viewer may use on this device's GPU unless its page says otherwise.
export function defaultMemory(isLive = false) {
  if (matchMedia('(pointer: coarse)').matches) return PHONE_MIB;
  return isLive ? LIVE_MIB : DESKTOP_MIB;
}

/** @param {number} ms */
const sleep = (ms) => new Promise((resolve) => setTimeout(resolve, ms));

// Returns a text that tells one version of a model from another.
/** @param {Scene} scene */
function contentOfScene(scene) {
  const {file, colors, tables} = scene.mesh;
  return JSON.stringify({...scene, coarse: scene.coarse?.file, mesh: [file, colors, tables]});
}

/** @param {HTMLCanvasElement} canvas */
function contextOf(canvas) {
  const gl = canvas.getContext(
      'webgl2', {alpha: false, antialias: false, depth: false, powerPreference: 'high-performance'});
  if (!gl) throw new TextError('noWebGl');
  return gl;
}

export class Viewer {
  /** @param {HTMLCanvasElement} canvas @param {ViewerOptions} options */
  constructor(canvas, options) {
    this.canvas = canvas;
    this.gl = options.gl ?? contextOf(canvas);
    this.shares = options.gl !== undefined;  // the canvas is another program's too
    this.closing = new AbortController();
    this.files = new SiteFiles(options.base, {...options.network, signal: this.closing.signal});
    if (options.live) this.files.gather();
    this.files.fetching.heard = (name, came, size) => this.hear(name, came, size);
    this.texts = options.texts ?? ENGLISH;
    this.losses = new Losses(this.texts, (line) => this.missing(line));
    this.memory = options.memory;
    this.live = options.live;
    this.follows = false;  // another version of a model that changes is coming
    this.file = options.model ?? 'tileset.json';
    this.texels = options.texels;
    this.shaders = options.shaders;
    this.sizes = new PictureSizes(canvas);
    /** @type {Mode} */
    this.mode = 'picture';
    /** @type {Background} */
    this.background = {above: [0.17, 0.19, 0.22], below: [0.34, 0.36, 0.39], continues: true};

    this.changed = () => {};     // after each change of the view
    /** @type {(came: number, all: number) => void} */
    this.begun = () => {};       // told how many bytes of the first mesh have come
    this.progressed = () => {};  // after each photograph that came, or could not be had
    this.followed = () => {};    // after another version of the scene has taken this one's place
    /** @type {(overrun: Overrun | null) => void} */
    this.crowded = () => {};     // told what overrun() says of each version
    /** @type {(line: string) => void} */
    this.missing = () => {};     // told in one line what could not be loaded; '': all could be
    /** @type {(lost: boolean) => void} */
    this.gpuLost = () => {};     // told when the GPU has gone, and when it is back
    this.finished = () => {};    // after the GPU has finished what it was given
    /** @type {(error: Error) => void} */
    this.failed = (error) => console.error(error);

    // The result of open().
    /** @type {{scene: Scene, shaders: Shaders, navigation: Navigation} | null} */
    this.model = null;
    /** @type {Promise<void> | null} */
    this.loading = null;
    this.loadsLater = false;
    this.rests = false;  // a headset shows the pictures
    /** @type {Size} */
    this.size = [canvas.width, canvas.height];  // of the canvas where it shows a still frame
    /** @type {Vector} */
    this.offset = [0, 0, 0];  // input position = position in the model + offset
    this.resident = new Uint32Array();  // for each tile of the scene, 1 or 0
    /** @type {ShownPart | null} */
    this.shownPart = null;  // of the surface; null: all of it
    this.isCropped = false;  // to a box, outside of which nothing is shown
    /** @type {{bytes: number, scale: number} | null} */
    this.room = null;  // number of photographs, once it is known
    this.forgetGpu();
    this.startGpu();
    options.signal?.addEventListener('abort', () => this.close());
    canvas.addEventListener('webglcontextlost', (event) => this.lose(event), {signal: this.closing.signal});
    canvas.addEventListener('webglcontextrestored', () => this.restore(), {signal: this.closing.signal});
  }

  // Asks the context for its extensions, which a context that was lost has no more, and clears a canvas of its own.
  startGpu() {
    const {gl} = this;
    /** @type {TexelForm} */
    this.form = texelForm(gl, this.texels);
    if (this.shares) return;
    gl.clearColor(0.25, 0.27, 0.3, 1);
    gl.clear(gl.COLOR_BUFFER_BIT);
  }

  // State of what is on the GPU, where nothing is on it.
  forgetGpu() {
    /** @type {Renderer | null} */
    this.renders = null;
    /** @type {Residents} */
    this.residents = new Residents(this);
    this.hasMesh = false;
    /** @type {string | null} */
    this.meshFile = null;  // whose mesh is drawn, all of it
    /** @type {ResidentChunks | null} */
    this.chunks = null;    // of a surface in several files
    /** @type {Scene | null} */
    this.taken = null;  // the scene whose tables are there
    /** @type {Fence | null} */
    this.fence = null;
    // `isFirst`: the first of its kind, or one that made something for those that follow, which took time.
    /** @type {{pictures: boolean, share: number, isDraft: boolean, isFirst: boolean, still?: boolean}} */
    this.shown = {pictures: false, share: 1, isDraft: false, isFirst: false};
    /** @type {Work & {now: number}} */
    this.asked = {now: 0, pixels: 1, of: 'whole'};
    /** @type {PictureTarget | null} */
    this.target = null;
    /** @type {{target: PictureTarget, camera: Camera, pose: Pose} | null} */
    this.drawn = null;
    this.looking = false;
    this.dirty = true;
    /** @type {Generator<Work, void> | 'done' | null} */
    this.still = null;
    /** @type {Size} */
    this.stillSize = [1, 1];
    /** @type {boolean} */
    this.stale = false;  // a still frame lacks photographs that came meanwhile
    /** @type {number} */
    this.changedAt = performance.now();
  }

  isOpen() {
    return this.renders !== null;
  }

  // These are there once open() has resolved.
  get opened() {
    if (!this.model) throw new Error('the model is not open yet');
    return this.model;
  }

  get scene() {
    return this.opened.scene;
  }

  get navigation() {
    return this.opened.navigation;
  }

  get renderer() {
    if (!this.renders) throw new Error('the model is not open yet');
    return this.renders;
  }

  // Resolves when the manifest and the shaders are there, for which it asks until it has them.
  async open() {
    const {live} = this;
    let version = null;
    if (live) {
      const state = () => this.insist('scene', () => this.liveState(live));
      while ((version = (await state()).version) === 0) await sleep(ASK_AGAIN_MS);
    }
    const shaders = this.shaders ?? await this.insist('scene', () => loadShaders(this.files));
    const scene = await this.insist('scene', () => loadScene(this.files, this.file, shaders));
    this.closing.signal.throwIfAborted();
    scene.version = version;
    const navigation = new Navigation(scene);
    this.model = {scene, shaders, navigation};
    this.renders = new Renderer(this.gl, scene, shaders);
    this.resize();
    const start = navigation.poseOfView(scene.first_view, this.canvas.width, this.canvas.height);
    navigation.set(start?.pose ?? navigation.pose, start?.fov ?? FIELD_OF_VIEW);
    return scene;
  }

  // Tells of the first mesh while it comes.
  /** @param {string} name @param {number} came @param {number | null} size */
  hear(name, came, size) {
    if (!this.model || this.hasMesh || size === null) return;
    const {coarse, mesh} = this.scene;
    if (name === (coarse ?? mesh).file) this.begun(came, size);
  }

  // Ends all: requests, drawing, and what is on the GPU.
  close() {
    this.closing.abort();
    this.renders?.release();
    this.fence?.release();
    this.forgetGpu();
  }

  /** @param {string} live @returns {Promise<LiveState>} */
  liveState(live) {
    return this.files.json(live);
  }

  // Returns the result of `load`; null if the network fails, which is shown until a later call succeeds.
  /**
   * @template T
   * @param {LossPart} part
   * @param {() => Promise<T>} load
   * @returns {Promise<T | null>}
   */
  async attempt(part, load) {
    try {
      const loaded = await load();
      this.losses.clearPart(part);
      return loaded;
    } catch (error) {
      if (!(error instanceof FetchFailure)) throw error;
      if (!this.passesBy(error)) this.losses.notePart(part, error);
      return null;
    }
  }

  // Returns whether the failed file belongs to a version that the next one is about to replace.
  /** @param {FetchFailure} failure */
  passesBy(failure) {
    return Boolean(this.live) && failure.gone;
  }

  // Returns the result of `load` once the network gives it, because nothing can be shown without.
  /**
   * @template T
   * @param {LossPart} part
   * @param {() => Promise<T>} load
   * @returns {Promise<T>}
   */
  async insist(part, load) {
    const {fetching} = this.files;
    for (let number = 1;; ++number) {
      const loaded = await this.attempt(part, load);
      if (loaded !== null) return loaded;
      await fetching.pause(fetching.laterMs, number);
    }
  }

  // Resolves when all is there that can be had. Photographs that are near what is looked at come first. What cannot be
  // had is asked for again later; until then the coarse mesh stands in for the fine one, averaged colours for
  // photographs, and other photographs for one that is missing.
  load() {
    this.loading ??= this.loadAll().finally(() => {
      this.loading = null;
      if (this.losses.any()) this.quietly(this.loadLater());
    });
    return this.loading;
  }

  // Begins anew where the GPU is lost meanwhile.
  async loadAll() {
    for (;;) {
      try {
        await this.loadMissing();
        return;
      } catch (error) {
        if (!this.isOfLostGpu(error)) throw error;
        await this.gpuBack();
      }
    }
  }

  async loadMissing() {
    const {coarse, mesh: {chunks, file}} = this.scene;
    if (coarse && !this.hasMesh) await this.loadMesh('coarse', coarse);
    if (!await this.loadViews()) {
      if (this.losses.anyGone()) await this.takeNewest();
      return;
    }
    const {scene} = this;
    if (chunks) {
      await this.loadChunks(chunks);
    } else {
      if (this.meshFile !== file) await this.loadMesh('mesh', scene.mesh);
      if (this.meshFile === file) await this.takeTables(scene);
      if (this.renderer.photographs) await this.residents.provide(this.camera());
    }
    if (this.meshFile === file) this.losses.clearPart('coarse');
    if (this.losses.anyGone()) await this.takeNewest();
  }

  // Learns all views, where the first one alone is known. False: their list cannot be had yet.
  async loadViews() {
    const {scene, renderer} = this;
    if (scene.view_file === null) return true;
    const whole = await this.attempt('views', () => withAllViews(this.files, scene));
    this.expect(renderer);
    if (!whole) return false;
    this.opened.scene = renderer.scene = whole;
    if (this.chunks) this.chunks.scene = whole;
    this.navigation.follow(whole);
    this.followed();
    return true;
  }

  // Draws chunks as they come, and photographs as soon as there is one.
  /** @param {Chunks} chunks */
  async loadChunks(chunks) {
    const {renderer, scene} = this;
    this.chunks ??= new ResidentChunks(this, scene, chunks);
    const drawn = this.chunks;
    const whole = drawn.provide(this.camera());
    const resident = this.taken ? this.resident : await this.attempt('tables', () => drawn.residentTiles());
    this.expect(renderer);
    if (resident) this.resident = resident;
    await Promise.race([whole, drawn.begun]);
    this.expect(renderer);
    if (resident && !this.taken && drawn.there.size > 0) this.takeScene(scene, null);
    const photographs = renderer.photographs ? this.residents.provide(this.camera()) : null;
    await Promise.all([whole, photographs]);
    if (photographs) await this.residents.provide(this.camera());
    if (this.chunks === drawn && drawn.isWhole()) this.meshFile = scene.mesh.file;
  }

  // Asks again for what is missing, later and later, until nothing is.
  async loadLater() {
    if (this.loadsLater) return;
    this.loadsLater = true;
    const {fetching} = this.files;
    try {
      for (let number = 1; this.losses.any(); ++number) {
        await fetching.pause(fetching.laterMs, number);
        this.residents.askAgain();
        this.chunks?.askAgain();
        await this.load();
      }
    } finally {
      this.loadsLater = false;
    }
  }

  /** @param {LossPart} part @param {MeshFile} mesh */
  async loadMesh(part, mesh) {
    const {renderer} = this;
    const loaded = await this.attempt(part, () => loadMesh(mesh));
    this.expect(renderer);
    if (!loaded) return;
    const {chunks} = this.scene.mesh;
    if (part === 'coarse' && chunks) {
      this.takeCoarse(loaded, chunks);
    } else {
      this.takeMesh(loaded, mesh.file);
    }
    this.invalidate();
  }

  /** @param {Mesh} mesh @param {Chunks} chunks */
  takeCoarse(mesh, chunks) {
    this.chunks ??= new ResidentChunks(this, this.scene, chunks);
    this.chunks.setCoarse(mesh);
    this.noteOffset(mesh);
    this.hasMesh = true;
  }

  // Draws the whole surface in place of what was drawn of it.
  /** @param {Mesh} mesh @param {string} file */
  takeMesh(mesh, file) {
    const {surface} = this.renderer;
    surface.removeAllBut(new Set([MESH]));
    surface.setMesh(MESH, mesh);
    this.chunks = null;
    this.noteOffset(mesh);
    this.meshFile = file;
    this.surfaceChanged(null);
  }

  /** @param {Mesh} mesh */
  noteOffset(mesh) {
    this.offset = mesh.offset ?? this.offset;
  }

  // Notes that the surface in `boxes` was replaced; null: all of it.
  /** @param {number[][] | null} boxes */
  surfaceChanged(boxes) {
    this.hasMesh = true;
    this.residents.surfaceChanged(boxes);
    this.invalidate();
  }

  // The site may have been written anew: the files of the version that this page knows are then gone.
  async takeNewest() {
    const scene = await this.newScene(true);
    if (!scene || contentOfScene(scene) === contentOfScene(this.scene)) return;
    if (await this.follow(scene)) this.followed();
  }

  // Returns the model as the server has it now; null: it cannot be had.
  /** @param {boolean} anew @returns {Promise<Scene | null>} */
  async newScene(anew) {
    const scene = await this.attempt('version', async () => {
      const listed = await loadScene(this.files, this.file, this.opened.shaders, anew);
      return withAllViews(this.files, listed);
    });
    if (scene) scene.version = this.scene.version;
    return scene;
  }

  // Another version of the scene in place of this one; what is as it was is not fetched again. False: it cannot be had,
  // and this one stays.
  /** @param {Scene} scene */
  async follow(scene) {
    const {renderer} = this;
    const {chunks, file} = scene.mesh;
    if (chunks) {
      if (!await this.followChunks(scene, chunks)) return false;
    } else {
      const mesh = this.meshFile === file ? null : await this.attempt('version', () => loadMesh(scene.mesh));
      this.expect(renderer);
      if (!mesh && this.meshFile !== file) return false;
      if (!await this.takeTables(scene, mesh, 'version')) return false;
    }
    await this.residents.provide(this.camera());
    return true;
  }

  // Draws the chunks of another version of the scene at once, so that no picture is of two versions.
  /** @param {Scene} scene @param {Chunks} chunks */
  async followChunks(scene, chunks) {
    const {renderer} = this;
    const next = new ResidentChunks(this, scene, chunks);
    if (this.chunks) next.keepFrom(this.chunks);
    const loaded = await this.attempt('version', async () => {
      if (!await next.stage(this.camera())) return null;
      return {coarse: scene.coarse && await loadMesh(scene.coarse), resident: await next.residentTiles()};
    });
    this.expect(renderer);
    if (!loaded) return false;
    const wasWhole = !this.chunks;
    this.chunks = next;
    this.resident = loaded.resident;
    next.replaceAll(loaded.coarse);
    if (wasWhole) this.surfaceChanged(null);
    this.meshFile = next.isWhole() ? scene.mesh.file : null;
    this.takeScene(scene, null);
    return true;
  }

  // All that a picture needs but photographs, at once, so that none is drawn of two versions. What is in the file that
  // it was in before is there already. False: something cannot be had.
  /** @param {Scene} scene @param {Mesh | null} mesh @param {LossPart} part */
  async takeTables(scene, mesh = null, part = 'tables') {
    const {renderer, taken} = this;
    // A mesh brings its colours.
    const newTables = mesh || !taken || scene.mesh.tables !== taken.mesh.tables;
    const newColors = !mesh && taken && scene.mesh.colors !== taken.mesh.colors;
    const loaded = await this.attempt(part, () => Promise.all([
      newTables ? loadTables(scene) : null, newColors ? loadColors(scene) : null,
    ]));
    this.expect(renderer);
    if (!loaded) return false;
    const [tables, colors] = loaded;
    if (mesh) this.takeMesh(mesh, scene.mesh.file);
    if (colors) renderer.surface.setColors(MESH, colors);
    this.takeScene(scene, tables);
    return true;
  }

  // `tables`: null where they are as they were.
  /** @param {Scene} scene @param {Tables | null} tables */
  takeScene(scene, tables) {
    const {gl, renderer} = this;
    if (tables) {
      renderer.surface.setTables(MESH, tables);
      this.resident = tables.resident;
    }
    const {resident} = this;
    if (!renderer.photographs) this.chooseForm(scene);
    if (this.scene !== scene) {
      this.residents.askAgain();
      this.losses.clear();
    }
    this.taken = this.opened.scene = renderer.scene = scene;
    this.navigation.follow(scene);
    this.room ??= {bytes: this.forPhotographs(resident.length), scale: this.shownScale()};
    const layout = makeLayout(scene, this.form, this.room.bytes, this.room.scale);
    this.crowded(this.overrun(layout, resident.length));
    if (!renderer.photographs?.follow(scene, layout, resident)) {
      renderer.photographs?.release();
      renderer.photographs = new Photographs(gl, renderer.programs, scene, layout, resident);
      this.residents.forget();
    }
    this.invalidate();
  }

  // Photographs of a model that changes come again whenever their masks change. So they are not compressed, which takes
  // long, where half of the memory has room for all as they are: the surface may still grow.
  /** @param {Scene} scene */
  chooseForm(scene) {
    if (!this.live || (this.texels ?? 'auto') !== 'auto') return;
    const plain = texelForm(this.gl, PLAIN);
    const layout = makeLayout(scene, plain, MOST_PLAIN * this.memory * MEBIBYTE, 1);
    if (layout.scale === 1 && layout.count === scene.views.length) this.form = plain;
  }

  // Asks for other versions until there will be none. `silent` is told whether the program that changes the model does
  // not answer, which it may do again.
  /** @param {(silent: boolean) => void} silent */
  async keepUp(silent) {
    for (;;) {
      await sleep(ASK_AGAIN_MS);
      const state = await this.nextState(silent);
      if (state.version === this.scene.version && !this.residents.next()) {
        this.follows = false;
        this.residents.limitRenewals(false);
        if (state.last) return;
        continue;
      }
      const began = performance.now();
      this.follows = true;
      this.residents.limitRenewals(true);
      try {
        const scene = await this.newScene(false);
        if (scene) scene.version = state.version;
        if (scene && await this.follow(scene)) this.followed();
      } catch (error) {
        this.follows = false;
        if (!this.isOfLostGpu(error)) throw error;
        await this.load();
      }
      // The next version does not wait for still frames where one takes long.
      this.follows = performance.now() - began > SLOW_VERSION_MS;
    }
  }

  // The state of a model that changes, once its server answers.
  /** @param {(silent: boolean) => void} silent */
  async nextState(silent) {
    const {fetching} = this.files;
    for (let number = 1;; ++number) {
      try {
        const state = await this.liveState(this.live ?? '');
        silent(false);
        return state;
      } catch (error) {
        this.follows = false;
        if (!(error instanceof FetchFailure)) throw error;
        silent(true);
      }
      await fetching.pause(fetching.laterMs, number);
    }
  }

  // Drawing rests until the browser gives the GPU back.
  /** @param {Event} event */
  lose(event) {
    event.preventDefault();  // otherwise it never does
    this.gpuLost(true);
  }

  // Makes all anew: nothing of what was on the GPU is there any more.
  restore() {
    this.gpuLost(false);
    if (!this.model) return;
    const {scene, shaders} = this.model;
    this.forgetGpu();
    this.startGpu();
    this.renders = new Renderer(this.gl, scene, shaders);
    this.renders.surface.setShownPart(this.shownPart);
    this.quietly(this.load());
  }

  // Throws ContextLost unless what is on the GPU is still this renderer's.
  /** @param {Renderer} renderer */
  expect(renderer) {
    if (renderer !== this.renders || this.gl.isContextLost()) throw new ContextLost();
  }

  // Returns whether something failed only because the GPU is lost.
  /** @param {unknown} error */
  isOfLostGpu(error) {
    return error instanceof ContextLost || this.gl.isContextLost();
  }

  async gpuBack() {
    do {
      await sleep(BACK_AGAIN_MS);
      this.closing.signal.throwIfAborted();
    } while (this.gl.isContextLost());
  }

  // Tells of what fails in the background, unless the GPU is lost or the viewer is closed.
  /** @param {Promise<unknown>} work */
  async quietly(work) {
    try {
      await work;
    } catch (error) {
      if (this.closing.signal.aborted || this.isOfLostGpu(error)) return;
      this.failed(error instanceof Error ? error : new Error(String(error)));
    }
  }

  // Bytes of what pictures are drawn to, and of what photographs with `tiles` take while they come.
  /** @param {number} tiles */
  besides(tiles) {
    const {renderer, size, sizes} = this;
    return renderer.bytesToDraw(sizes.moving(), size) +
        Photographs.bytesBesides(this.scene, this.form, tiles);
  }

  // Returns the bytes that the surface takes, or may take once its chunks have come.
  surfaceBytes() {
    const bytes = this.renderer.surface.bytes();
    return this.chunks && this.chunks.room < Infinity ? Math.max(bytes, this.chunks.room) : bytes;
  }

  // Returns how many bytes chunks may take on the GPU, which would take `all`.
  /** @param {number} all */
  roomForChunks(all) {
    const left = this.memory * MEBIBYTE - this.besides(this.resident.length);
    return Math.max(0, Math.min(CHUNKS_VARY * all, MOST_FOR_CHUNKS * left));
  }

  // Returns the bytes that besides() and the surface leave for photographs with `tiles`.
  /** @param {number} tiles */
  forPhotographs(tiles) {
    const {renderer} = this;
    const taken = renderer.bytes() - renderer.surface.bytes() + this.surfaceBytes();
    const left = this.memory * MEBIBYTE - taken - this.besides(tiles);
    return Math.max(LEAST_FOR_PHOTOGRAPHS * this.memory, left);
  }

  // Null: all has room. Photographs take their least share of what would be enough.
  /** @param {Layout} layout @param {number} tiles @returns {Overrun | null} */
  overrun(layout, tiles) {
    const mesh = this.surfaceBytes() / MEBIBYTE;
    const others = mesh + this.besides(tiles) / MEBIBYTE;
    const all = others + layout.bytes / MEBIBYTE;
    if (all <= this.memory) return null;
    const share = LEAST_FOR_PHOTOGRAPHS / MEBIBYTE;
    return {all, mesh, allowed: this.memory, enough: Math.ceil(Math.max(all, others / (1 - share)))};
  }

  // Scale of photographs at which they have as many pixels as an interactive frame.
  shownScale() {
    const longest = Math.max(...viewsOf(this.scene).map(({width, height}) => Math.max(width, height)));
    return Math.max(...this.sizes.moving()) / longest;
  }

  // Returns what is on the GPU: bytes now, at most so far, and allowed; photographs, and how many there is room for.
  gpuMemory() {
    const {renderer, residents, form} = this;
    const {total} = residents.progress();
    return {
      bytes: renderer.bytes(),
      most: renderer.mostBytes,
      allowed: this.memory * MEBIBYTE,
      photographs: residents.current().size,
      room: total,
      texels: form.name,
    };
  }

  camera(width = this.size[0], height = this.size[1]) {
    return cameraAt(this.navigation.pose, this.navigation.fov, width, height);
  }

  resize() {
    if (this.rests) return;
    const [width, height] = this.sizes.whole();
    if (this.size[0] === width && this.size[1] === height) return;
    this.size = [width, height];
    this.setCanvasSize(this.size);
    this.invalidate();
  }

  // A canvas whose size is set is empty until something is drawn in it.
  /** @param {Size} size */
  setCanvasSize([width, height]) {
    const {canvas} = this;
    if (canvas.width === width && canvas.height === height) return;
    canvas.width = width;
    canvas.height = height;
  }

  // Shows a picture on the canvas, which then has `size`, or `this.size` if its box would follow.
  /** @param {Picture} picture @param {Size} size */
  present(picture, size) {
    const {canvas, sizes} = this;
    if (canvas.width !== size[0] || canvas.height !== size[1]) {
      const {clientWidth} = canvas;
      this.setCanvasSize(size);
      if (canvas.clientWidth !== clientWidth) {
        sizes.boxFollows = true;
        this.setCanvasSize(this.size);
      }
    }
    this.renderer.present(picture, canvas.width, canvas.height, this.backgroundNow());
  }

  // Something changed: the next frame is drawn anew, and a still frame after a rest.
  invalidate() {
    this.dirty = true;
    this.still = null;
    this.stale = false;
    this.changedAt = performance.now();
  }

  // A photograph came. A still frame that is drawn or being drawn stays until there is one that shows it, and the
  // camera rests as before.
  improve() {
    if (this.still && this.shown.pictures) {
      this.stale = true;
    } else {
      this.dirty = true;
      this.still = null;
    }
  }

  // Leaves the canvas alone, and frees the targets of its pictures, while a headset shows pictures of drawTarget().
  rest() {
    this.rests = true;
    this.still = this.target = this.drawn = null;
    this.renderer.targets.release();
  }

  // Draws in the canvas again.
  goOn() {
    if (this.closing.signal.aborted) return;
    this.rests = false;
    this.target = this.drawn = null;
    this.renderer.targets.release();
    this.resize();
    this.moved();
  }

  moved() {
    this.invalidate();
    this.changed();
  }

  /** @param {string} mode */
  setMode(mode) {
    this.mode = MODES.find((known) => known === mode) ?? 'picture';
    this.invalidate();
    this.changed();
  }

  // Shows a part of the surface alone; null: all of it. `isCropped`: outside of a box, there is nothing.
  /** @param {ShownPart | null} part @param {boolean} isCropped */
  setShownPart(part, isCropped) {
    this.shownPart = part;
    this.isCropped = isCropped;
    this.renderer.surface.setShownPart(part);
    this.invalidate();
  }

  /** @param {string} quality */
  setQuality(quality) {
    this.sizes.setQuality(quality);
    this.invalidate();
    this.resize();
  }

  // Draws until it is closed; `advance(seconds)` moves the camera by what is held, and says whether it did.
  /** @param {(seconds: number) => boolean} advance */
  run(advance) {
    let last = performance.now();
    const frame = (/** @type {number} */ now) => {
      if (this.closing.signal.aborted) return;
      requestAnimationFrame(frame);
      const seconds = (now - last) / 1000;
      last = now;
      if (this.rests) return;
      try {
        if (this.navigation.advance(now) || advance(seconds)) this.moved();
        this.step(now);
      } catch (error) {
        if (this.isOfLostGpu(error)) return;
        this.failed(error instanceof Error ? error : new Error(String(error)));
        throw error;
      }
    };
    requestAnimationFrame(frame);
  }

  // Gives the GPU no new work before it has finished the last.
  /** @param {number} now */
  step(now) {
    if (!this.hasMesh || this.gl.isContextLost() || this.busy(now)) return;
    if (this.dirty) {
      this.drawNow();
      const {width, height} = this.target ?? {width: 1, height: 1};
      const isUsual = this.shown.pictures && !this.shown.isFirst;
      this.watch(now, {pixels: width * height, of: isUsual ? 'frame' : 'whole'});
    } else if (now - this.changedAt > STILL_AFTER_MS && !this.follows) {
      const work = this.refine();
      if (work.of !== 'nothing') this.watch(now, work);
    }
  }

  /** @param {number} now @param {Work} work */
  watch(now, work) {
    this.fence = new Fence(this.gl);
    this.asked = {now, ...work};
  }

  /** @param {number} now */
  busy(now) {
    if (!this.fence) return false;
    if (!this.fence.passed()) return true;
    this.fence = null;
    const {of, pixels} = this.asked;
    const ms = now - this.asked.now;
    if (of === 'frame') this.sizes.adapt(ms);
    if (of === 'surface') this.sizes.noteSurface(ms);
    if (of === 'part' || (of === 'frame' && !this.shown.isDraft)) this.sizes.noteTime(ms, pixels);
    this.finished();
    return false;
  }

  // Draws an interactive frame of that size.
  drawNow(size = this.sizes.next(), mayBeDraft = this.mode === 'picture') {
    const isDraft = mayBeDraft && this.sizes.isDraft && this.renderer.readyForDrafts();
    const target = this.drawTarget(this.camera(...size), isDraft);
    this.present(target, this.sizes.canvasFor(target));
  }

  // A measure of the model, and a model that is cropped, end where they end.
  /** @returns {Background} */
  backgroundNow() {
    const continues = this.background.continues && this.mode === 'picture' && !this.isCropped;
    return {...this.background, continues};
  }

  // Draws a camera's picture as an interactive frame, into the target that it returns.
  /** @param {Camera} camera */
  drawTarget(camera, isDraft = false) {
    const {renderer} = this;
    this.dirty = false;
    const target = renderer.draw(camera, isDraft);
    this.target = target;
    this.drawn = {target, camera, pose: this.navigation.pose};
    // Until the programs are compiled and a photograph has come, averaged colours are the picture.
    const ready = renderer.ready();
    const pictures = ready && Boolean(renderer.photographs?.cells.size);
    if (this.mode !== 'picture' || !pictures) {
      renderer.drawMode(target, pictures || this.mode === 'geometry' ? this.mode : 'colours');
    }
    const isFirst = isDraft !== this.shown.isDraft || renderer.hasPrepared;
    this.shown = {pictures, share: this.sizes.share, isDraft, isFirst};
    if (pictures) this.quietly(this.look());
    if (!ready && renderer.photographs) this.waitForPrograms();
    return target;
  }

  // Measures which share of the last picture was photographed, for the hold: of its middle with a photograph's aspect,
  // as the window may be wider.
  async look() {
    if (this.looking) return;
    const {renderer} = this;
    const first = this.scene.views[this.scene.first_view];
    const aspect = first ? first.width / first.height : 1;
    this.looking = true;
    try {
      for (let seen = null; seen !== this.drawn && this.drawn && renderer.targets.has(this.drawn.target);) {
        seen = this.drawn;
        const share = await renderer.glances.photographedShare(seen.target, seen.camera, aspect);
        this.expect(renderer);
        this.navigation.hold.measured(seen.pose, share);
        this.quietly(this.provide(seen.camera));
      }
    } finally {
      this.looking = false;
    }
  }

  // Loads what that camera needs, while pictures go on.
  /** @param {Camera} camera */
  async provide(camera) {
    const {residents, chunks} = this;
    if (!residents.scarce() && (!chunks || chunks.isWhole())) return;
    const [cameChunks] = await Promise.all([chunks?.provide(camera), residents.provide(camera)]);
    if (cameChunks) await residents.provide(camera);
    if (this.losses.any()) await this.loadLater();
  }

  waitForPrograms() {
    setTimeout(() => this.invalidate(), PROGRAMS_MS);
  }

  // Draws what comes next of a still frame, and says what that is.
  /** @returns {Work} */
  refine() {
    const again = this.still === 'done' && this.stale;
    if (this.still === 'done' && !again) return {pixels: 0, of: 'nothing'};
    if (!this.still || again) {
      this.stale = false;
      this.still = this.mode !== 'picture' || !this.shown.pictures ? this.refineMode() : this.refinePicture(again);
    }
    const {done, value} = /** @type {Generator<Work, void>} */ (this.still).next();
    if (done) this.still = 'done';
    return value ?? {pixels: 0, of: 'nothing'};
  }

  // The picture as `lumatlas render` draws it. `again`: in place of an earlier one of the same camera.
  /** @param {boolean} again @returns {Generator<Work, void>} */
  *refinePicture(again) {
    const {renderer, sizes} = this;
    const size = sizes.still();
    const isThere = again && size.join() === this.stillSize.join();
    if (sizes.isSlow) {
      const passes = isThere ? [size] : sizes.passes();
      for (const pass of passes) yield* this.refineByParts(pass, isThere ? null : this.target);
      if (!sizes.hasTimeForSamples(size)) return;
    }
    const camera = this.camera(...size);
    this.stillSize = size;
    while (!renderer.readyForStills()) yield {pixels: 0, of: 'nothing'};
    for (const pixels of renderer.drawStill(camera, true)) yield {pixels, of: 'part'};
    this.presentStill();
    yield {pixels: size[0] * size[1], of: 'whole'};
  }

  // The picture without samples at silhouettes, in small parts that are shown as they come. `under`: a coarser one.
  /** @param {Size} size @param {PictureTarget | null} under @returns {Generator<Work, void>} */
  *refineByParts(size, under) {
    const {renderer, sizes} = this;
    const camera = this.camera(...size);
    this.stillSize = size;
    const target = renderer.beginParts(camera, under);
    this.target = target;
    this.drawn = {target, camera, pose: this.navigation.pose};
    yield {pixels: 1, of: 'surface'};
    let presented = 0;
    for (const part of partsOf(camera, sizes.partPx())) {
      renderer.blendPart(target, camera, part);
      if (performance.now() - presented > PRESENT_MS) {
        this.presentStill();
        presented = performance.now();
      }
      yield {pixels: part.size[0] * part.size[1], of: 'part'};
    }
    this.presentStill();
    yield {pixels: camera.width * camera.height, of: 'whole'};
  }

  presentStill() {
    this.present(this.renderer.stillTarget(...this.stillSize), this.size);
  }

  /** @returns {Generator<Work, void>} */
  *refineMode() {
    const [width, height] = this.sizes.moving();
    this.drawNow([width, height], false);
    yield {pixels: width * height, of: 'whole'};
    this.stale ||= this.mode === 'picture' && this.shown.pictures;  // the first photograph came
  }

  // Depth of the surface at a point of the canvas, in CSS pixels; 0: there is none, or only what is far.
  /** @param {number} x @param {number} y */
  pick(x, y) {
    const {target} = this;
    if (!target || this.gl.isContextLost() || !this.renderer.targets.has(target)) return 0;
    const box = this.canvas.getBoundingClientRect();
    const inside = (/** @type {number} */ v, /** @type {number} */ size, /** @type {number} */ pixels) =>
        Math.max(0, Math.min(pixels - 1, v / size * pixels));
    const {renderer} = this;
    const depth = renderer.depthAt(target, inside(x, box.width, target.width), inside(y, box.height, target.height));
    return depth < renderer.scene.depth_before_far ? depth : 0;
  }

  // Returns how far the surface is from a position along a direction, which has the length one; Infinity: there is
  // none, or only one that is far.
  /** @param {Vector} from @param {Vector} direction */
  distanceAlong(from, direction) {
    if (!this.hasMesh || this.gl.isContextLost()) return Infinity;
    const rotation = lookingAlong(direction, this.navigation.up);
    const {depth} = this.renderer.surfaceOfPixel(cameraAt({position: from, rotation}, RAY_FOV, 1, 1));
    return depth > 0 && depth < this.scene.depth_before_far ? depth : Infinity;
  }

  // A camera's picture as `lumatlas render` draws it: RGBA, row by row from the top, with alpha 0 where there is no
  // surface; at once.
  /** @param {Camera} camera */
  pixels(camera) {
    const {gl, renderer} = this;
    const parts = renderer.drawStill(camera, false);
    let step = parts.next();
    while (!step.done) step = parts.next();
    const rows = new Uint8Array(4 * camera.width * camera.height);
    gl.bindFramebuffer(gl.FRAMEBUFFER, step.value.framebuffer);
    gl.pixelStorei(gl.PACK_ALIGNMENT, 1);
    gl.readPixels(0, 0, camera.width, camera.height, gl.RGBA, gl.UNSIGNED_BYTE, rows);
    const picture = new Uint8Array(rows.length);
    const width = 4 * camera.width;
    for (let y = 0; y < camera.height; ++y) {
      picture.set(rows.subarray((camera.height - 1 - y) * width, (camera.height - y) * width), y * width);
    }
    this.invalidate();
    return picture;
  }

  // Returns the canvas as a file; null: nothing is drawn yet.
  /** @returns {Promise<Blob | null>} */
  async screenshot() {
    const {canvas, size, target} = this;
    if (!target) return null;
    if (this.mode === 'picture' && this.shown.pictures && this.still === 'done') {
      this.presentStill();
    } else {
      this.present(target, size);
    }
    return new Promise((resolve) => canvas.toBlob(resolve, 'image/png'));
  }
}
