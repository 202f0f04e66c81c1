// SPDX-License-Identifier: GPL-3.0-or-later
// The page. For other pages: `openModel(canvas, options)` shows a site's model in a canvas of their own.
import {MODES, parseAddress, printAddress} from './address.js';
import {cameraAt} from './camera.js';
import {Controls} from './controls.js';
import {FetchFailure} from './fetching.js';
import {Interface} from './interface.js';
import {makeLayout} from './layout.js';
import {Losses} from './losses.js';
import {loadColors, loadMesh, loadScene, loadShaders, loadTables} from './model.js';
import {Navigation} from './navigation.js';
import {texelForm} from './photograph_forms.js';
import {Photographs} from './photographs.js';
import {Renderer} from './renderer.js';
import {Residents} from './residents.js';
import {SiteFiles} from './site_files.js';

const MEBIBYTE = 1 << 20;
const LEAST_FOR_PHOTOGRAPHS = MEBIBYTE / 8;  // of each mebibyte
const ASK_AGAIN_MS = 1000;  // what a model that changes is like now
const STILL_AFTER_MS = 250;
const SLOW_MS = 40;        // a picture that the GPU takes longer for makes the next one smaller
const FAST_MS = 15;
const LEAST_SHARE = 0.2;   // of a moving picture's pixels along a side
const FIRST_SHARE = 0.5;
const MOST_CHANGE = 1.6;   // of the share, from one picture to the next
const MOST_PIXELS = 2.1e6;        // of a moving picture
const MOST_STILL_PIXELS = 4.2e6;

// Of GPU memory: what a phone gives a page without closing others.
const MEMORY_MIB = matchMedia('(pointer: coarse)').matches ? 100 : 200;

// Pixels for each of the window's along a side, in moving and in still pictures, where the screen has them; `share`: of
// them moving pictures have, null: as many as the GPU draws in time.
const QUALITIES = {
  auto: {share: null, moving: 1, still: 2},
  sharp: {share: 1, moving: 2, still: 2},
  fast: {share: 0.5, moving: 1, still: 1},
};

export {texelForm};

const sleep = (ms) => new Promise((resolve) => setTimeout(resolve, ms));

export class Viewer {
  // `options`: {base, memory, texels, live, network}; `memory`: MiB on the GPU; `texels`: see texelForm(); `live`: the
  // file that says which version of a changing model there is; `network`: see NetworkOptions.
  constructor(canvas, options) {
    this.canvas = canvas;
    this.gl = canvas.getContext(
        'webgl2', {alpha: false, antialias: false, depth: false, powerPreference: 'high-performance'});
    if (!this.gl) throw new Error('This page needs WebGL 2, which this browser does not have or has switched off.');
    this.files = new SiteFiles(options.base, options.network);
    this.losses = new Losses((line) => this.missing(line));
    this.memory = options.memory;
    this.live = options.live;
    this.form = texelForm(this.gl, options.texels);
    this.residents = new Residents(this);
    this.mode = 'picture';
    this.quality = 'auto';
    this.share = FIRST_SHARE;
    this.gl.clearColor(0.25, 0.27, 0.3, 1);
    this.gl.clear(this.gl.COLOR_BUFFER_BIT);
    this.background = {above: [0.17, 0.19, 0.22], below: [0.34, 0.36, 0.39]};
    this.changed = () => {};  // after each change of the view
    this.progressed = () => {};
    this.crowded = () => {};  // told what overrun() says of each version
    this.missing = () => {};  // told in one line what could not be loaded; '': all could be
    this.followed = () => {};  // after another version of the scene has taken this one's place
    this.failed = (error) => console.error(error);
    this.shown = {};
  }

  // Resolves when the manifest and the shaders are there, for which it asks until it has them.
  async open() {
    while (this.live && (await this.insist('scene', () => this.files.json(this.live))).version === 0) {
      await sleep(ASK_AGAIN_MS);
    }
    const [scene, shaders] = await Promise.all([
      this.insist('scene', () => loadScene(this.files)), this.insist('scene', () => loadShaders(this.files)),
    ]);
    this.scene = scene;
    this.navigation = new Navigation(this.scene);
    this.renderer = new Renderer(this.gl, this.scene, shaders);
    this.resize();
    const start = this.navigation.poseOfView(this.scene.first_view, this.canvas.width, this.canvas.height);
    this.navigation.set(start.pose, start.fov);
    return this.scene;
  }

  // What `load` returns; null where the network does not give it, which is told until a later call has it.
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

  // Whether it is a file of a version that the next one is about to replace.
  passesBy(failure) {
    return Boolean(this.live) && failure.gone;
  }

  // What `load` returns, once the network gives it: nothing can be shown without.
  async insist(part, load) {
    const {fetching} = this.files;
    for (let number = 1;; ++number) {
      const loaded = await this.attempt(part, load);
      if (loaded) return loaded;
      await fetching.pause(fetching.laterMs, number);
    }
  }

  // Resolves when all is there that can be had. Photographs that are near what is looked at come first. What cannot be
  // had is asked for again later; until then the coarse mesh stands in for the fine one, averaged colours for
  // photographs, and other photographs for one that is missing.
  load() {
    this.loading ??= this.loadAll().finally(() => {
      this.loading = null;
      if (this.losses.any()) this.loadLater().catch((error) => this.failed(error));
    });
    return this.loading;
  }

  async loadAll() {
    await this.loadMeshes();
    if (this.meshFile === this.scene.mesh.file) await this.takeTables(this.scene);
    if (this.renderer.photographs) await this.residents.provide(this.camera());
    if (this.losses.anyGone()) await this.takeNewest();
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
        await this.load();
      }
    } finally {
      this.loadsLater = false;
    }
  }

  async loadMeshes() {
    const {scene} = this;
    if (scene.coarse && !this.hasMesh) await this.loadMesh('coarse', scene.coarse);
    if (this.meshFile !== scene.mesh.file) await this.loadMesh('mesh', scene.mesh);
    if (this.meshFile === scene.mesh.file) this.losses.clearPart('coarse');
  }

  async loadMesh(part, mesh) {
    const loaded = await this.attempt(part, () => loadMesh(this.files, mesh));
    if (!loaded) return;
    this.takeMesh(loaded, mesh.file);
    this.invalidate();
  }

  takeMesh(mesh, file) {
    this.renderer.setMesh(mesh);
    this.residents.forget();  // depths are drawn from the mesh
    this.meshFile = file;
    this.hasMesh = true;
  }

  // The site may have been written anew: the files of the version that this page knows are then gone.
  async takeNewest() {
    const scene = await this.attempt('version', () => loadScene(this.files, true));
    if (!scene || JSON.stringify(scene) === JSON.stringify(this.scene)) return;
    if (await this.follow(scene)) this.followed();
  }

  // Another version of the scene in place of this one; what is as it was is not fetched again. False: it cannot be had,
  // and this one stays.
  async follow(scene) {
    const mesh = this.meshFile === scene.mesh.file ? null :
        await this.attempt('version', () => loadMesh(this.files, scene.mesh));
    if (!mesh && this.meshFile !== scene.mesh.file) return false;
    if (!await this.takeTables(scene, mesh, 'version')) return false;
    await this.residents.provide(this.camera());
    return true;
  }

  // All that a picture needs but photographs, at once, so that none is drawn of two versions. What is in the file that
  // it was in before is there already. False: something cannot be had.
  async takeTables(scene, mesh = null, part = 'tables') {
    const {files, gl, renderer, losses} = this;
    const isNew = (name) => mesh || !this.taken || scene[name]?.file !== this.taken[name]?.file;
    const loaded = await this.attempt(part, () => Promise.all([
      isNew('tables') ? loadTables(files, scene) : null, isNew('colors') ? loadColors(files, scene) : null,
    ]));
    if (!loaded) return false;
    const [tables, colors] = loaded;
    if (mesh) this.takeMesh(mesh, scene.mesh.file);
    if (colors) renderer.setColors(colors);
    if (tables) {
      renderer.setTables(tables);
      this.resident = tables.resident;
    }
    if (this.scene !== scene) this.residents.askAgain();
    if (this.scene !== scene) losses.clear();
    this.taken = this.scene = this.renderer.scene = scene;
    this.navigation.follow(scene);
    this.room ??= {bytes: this.forPhotographs(this.resident.length), scale: this.shownScale()};
    const layout = makeLayout(scene, this.form, this.room.bytes, this.room.scale);
    this.crowded(this.overrun(layout, this.resident.length));
    if (!renderer.photographs?.follow(scene, layout, this.resident)) {
      renderer.photographs?.release();
      renderer.photographs = new Photographs(gl, renderer.programs, scene, layout, this.resident);
      this.residents.forget();
    }
    this.invalidate();
    return true;
  }

  // Asks for other versions until there will be none; `followed` is called after each. `silent` is told whether the
  // program that changes the model does not answer, which it may do again.
  async keepUp(silent) {
    for (;;) {
      await sleep(ASK_AGAIN_MS);
      const state = await this.liveState(silent);
      if (state.version === this.scene.version && !this.residents.next()) {
        if (state.last) return;
        continue;
      }
      const scene = await this.attempt('version', () => loadScene(this.files));
      if (scene && await this.follow(scene)) this.followed();
    }
  }

  // {version, last} of a model that changes, once its server answers.
  async liveState(silent) {
    const {fetching} = this.files;
    for (let number = 1;; ++number) {
      try {
        const state = await this.files.json(this.live);
        silent(false);
        return state;
      } catch (error) {
        if (!(error instanceof FetchFailure)) throw error;
        silent(true);
      }
      await fetching.pause(fetching.laterMs, number);
    }
  }

  // Of the memory, bytes: what pictures are drawn to, and what photographs with so many tiles take while they come.
  besides(tiles) {
    const {canvas, renderer} = this;
    return renderer.bytesToDraw(this.movingSize(), [canvas.width, canvas.height]) +
        Photographs.bytesBesides(this.scene, this.form, tiles);
  }

  // What is left by these and the mesh.
  forPhotographs(tiles) {
    const left = this.memory * MEBIBYTE - this.renderer.bytes() - this.besides(tiles);
    return Math.max(LEAST_FOR_PHOTOGRAPHS * this.memory, left);
  }

  // MiB, where more is needed than is allowed: all of it, what of it is the mesh, and what would have to be allowed,
  // of which photographs take their least share. Null: all has room.
  overrun(layout, tiles) {
    const mesh = this.renderer.modelBytes() / MEBIBYTE;
    const others = mesh + this.besides(tiles) / MEBIBYTE;
    const all = others + layout.bytes / MEBIBYTE;
    if (all <= this.memory) return null;
    const share = LEAST_FOR_PHOTOGRAPHS / MEBIBYTE;
    return {all, mesh, allowed: this.memory, enough: Math.ceil(Math.max(all, others / (1 - share)))};
  }

  // Of photographs that have as many pixels as a moving picture.
  shownScale() {
    const longest = Math.max(...this.scene.views.filter(Boolean).map(({width, height}) => Math.max(width, height)));
    return Math.max(...this.movingSize()) / longest;
  }

  // What is on the GPU: bytes now, at most so far, and allowed; photographs, and how many there is room for.
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

  camera(width = this.canvas.width, height = this.canvas.height) {
    return cameraAt(this.navigation.pose, this.navigation.fov, width, height);
  }

  // So many pixels for each of the window's, but not more than the screen has, nor than that in all.
  sizeWith(ratio, most) {
    const {width, height} = this.canvas.getBoundingClientRect();
    const wanted = Math.min(window.devicePixelRatio || 1, ratio);
    const share = wanted * Math.min(1, Math.sqrt(most / Math.max(1, width * height * wanted * wanted)));
    return [width, height].map((v) => Math.max(1, Math.round(v * share)));
  }

  // Of a moving picture, at most.
  movingSize() {
    return this.sizeWith(QUALITIES[this.quality].moving, MOST_PIXELS);
  }

  // A still picture has the canvas' pixels where the GPU draws moving ones whole in time.
  stillSize() {
    const {canvas} = this;
    return this.quality === 'auto' && this.share < 1 ? this.movingSize() : [canvas.width, canvas.height];
  }

  resize() {
    const {canvas} = this;
    const size = this.sizeWith(QUALITIES[this.quality].still, MOST_STILL_PIXELS);
    if (canvas.width === size[0] && canvas.height === size[1]) return;
    [canvas.width, canvas.height] = size;
    this.invalidate();
  }

  // Something changed: the next frame is drawn anew, and a still picture after a rest.
  invalidate() {
    this.dirty = true;
    this.still = null;
    this.changedAt = performance.now();
  }

  moved() {
    this.invalidate();
    this.changed();
  }

  setMode(mode) {
    this.mode = MODES.includes(mode) ? mode : 'picture';
    this.invalidate();
    this.changed();
  }

  setQuality(quality) {
    this.quality = quality in QUALITIES ? quality : 'auto';
    this.share = QUALITIES[this.quality].share ?? this.share;
    this.invalidate();
    this.resize();
  }

  // Draws for ever; `advance(seconds)` moves the camera by what is held, and says whether it did.
  run(advance) {
    let last = performance.now();
    const frame = (now) => {
      requestAnimationFrame(frame);
      try {
        const seconds = (now - last) / 1000;
        last = now;
        if (this.navigation.advance(now) || advance(seconds)) this.moved();
        this.step(now);
      } catch (error) {
        this.failed(error);
        throw error;
      }
    };
    requestAnimationFrame(frame);
  }

  // Nothing new is asked of the GPU before it has done what it was asked for.
  step(now) {
    if (!this.hasMesh || this.gl.isContextLost() || this.busy(now)) return;
    if (this.dirty) {
      this.drawNow();
      this.watch(now, true);
    } else if (now - this.changedAt > STILL_AFTER_MS) {
      this.refine();
      this.watch(now, false);
    }
  }

  watch(now, adapts) {
    this.fence = this.gl.fenceSync(this.gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
    this.gl.flush();
    this.asked = {now, adapts: adapts && this.shown.pictures};
  }

  busy(now) {
    const {gl} = this;
    if (!this.fence) return false;
    if (gl.clientWaitSync(this.fence, gl.SYNC_FLUSH_COMMANDS_BIT, 0) === gl.TIMEOUT_EXPIRED) return true;
    gl.deleteSync(this.fence);
    this.fence = null;
    if (this.asked.adapts) this.adapt(now - this.asked.now);
    return false;
  }

  // Fewer pixels where the GPU is slow. The first picture, for which programs are made ready, says nothing.
  adapt(ms) {
    this.pictures = (this.pictures ?? 0) + 1;
    if (QUALITIES[this.quality].share !== null || this.pictures < 2) return;
    const change = ms > SLOW_MS ? Math.sqrt(SLOW_MS / ms) : ms < FAST_MS ? MOST_CHANGE : 1;
    this.share = Math.max(LEAST_SHARE, Math.min(1, this.share * Math.max(1 / MOST_CHANGE, change)));
  }

  drawNow() {
    const {canvas, renderer} = this;
    this.dirty = false;
    const size = this.movingSize().map((v) => Math.max(1, Math.round(v * this.share)));
    const camera = this.camera(...size);
    const target = renderer.draw(camera);
    this.target = target;
    this.drawn = {target, camera, pose: this.navigation.pose};
    // Until the programs are compiled and a photograph has come, averaged colours are the picture.
    const ready = renderer.ready();
    const pictures = ready && renderer.photographs.cells.size > 0;
    if (this.mode !== 'picture' || !pictures) {
      renderer.drawMode(target, pictures || this.mode === 'geometry' ? this.mode : 'colours');
    }
    renderer.present(target.colour, canvas.width, canvas.height, this.background);
    this.shown = {pictures, share: this.share};
    if (pictures) this.look();
    if (!ready && renderer.photographs) this.waitForPrograms();
  }

  // How much of the last picture was photographed; of what a photograph would show of it, as the window may be wider.
  async look() {
    if (this.looking) return;
    this.looking = true;
    const {width, height} = this.scene.views[this.scene.first_view];
    let seen;
    do {
      seen = this.drawn;
      const share = await this.renderer.glances.photographedShare(seen.target, seen.camera, width / height);
      this.navigation.hold.measured(seen.pose, share);
      this.provide(seen.camera);
    } while (seen !== this.drawn);
    this.looking = false;
  }

  // What that camera needs, while pictures go on.
  async provide(camera) {
    if (!this.residents.scarce()) return;
    try {
      await this.residents.provide(camera);
      if (this.losses.any()) await this.loadLater();
    } catch (error) {
      this.failed(error);
    }
  }

  waitForPrograms() {
    setTimeout(() => this.invalidate(), 100);
  }

  // One part of the picture as `lumatlas render` draws it; on the canvas once all parts are done.
  refine() {
    const {canvas, renderer} = this;
    if (this.still === 'done') return;
    if (this.mode !== 'picture' || !this.shown.pictures) return this.refineMode();
    if (!renderer.readyForStills()) return;
    if (!this.still) this.still = renderer.drawStill(this.camera(...this.stillSize()), true);
    const {done, value} = this.still.next();
    if (!done) return;
    renderer.present(value.colour, canvas.width, canvas.height, this.background);
    this.still = 'done';
    this.shown.still = true;
  }

  refineMode() {
    const share = this.share;
    this.share = 1;
    this.drawNow();
    this.share = share;
    this.still = 'done';
  }

  // Depth of the surface at a place of the canvas, in CSS pixels; 0: there is none.
  pick(x, y) {
    if (!this.target) return 0;
    const box = this.canvas.getBoundingClientRect();
    const inside = (v, size, pixels) => Math.max(0, Math.min(pixels - 1, v / size * pixels));
    return this.renderer.depthAt(
        this.target, inside(x, box.width, this.target.width), inside(y, box.height, this.target.height));
  }

  // A camera's picture as `lumatlas render` draws it: RGBA, row by row from the top, with alpha 0 where there is no
  // surface; at once.
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

  // What is on the canvas, as a file.
  async screenshot() {
    const {renderer, canvas} = this;
    const target = this.mode === 'picture' && this.still === 'done' ? renderer.targets.get('still') : this.target;
    renderer.present(target.colour, canvas.width, canvas.height, this.background);
    return new Promise((resolve) => canvas.toBlob(resolve, 'image/png'));
  }
}

function save(blob, name) {
  const link = document.createElement('a');
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}

// Address and view follow each other, without an entry in the history for each movement.
function linkAddress(viewer, page) {
  const read = (address) => {
    const state = parseAddress(new URL(address).hash);
    if (!state) return false;
    viewer.navigation.set(state.pose, state.fov);
    viewer.setMode(state.mode);
    page.showMode(viewer.mode);
    return true;
  };
  let timer = 0;
  const write = () => {
    timer = 0;
    const {navigation, mode} = viewer;
    history.replaceState(null, '', printAddress({pose: navigation.pose, fov: navigation.fov, mode}));
  };
  read(location.href);
  viewer.changed = () => {
    timer ||= setTimeout(write, 200);
  };
  addEventListener('hashchange', (event) => {
    if (read(event.newURL)) viewer.invalidate();
  });
}

function memoryNotice({all, mesh, allowed, enough}) {
  return `This model takes up to ${Math.ceil(all)} MiB of the GPU's memory, ${Math.round(mesh)} of them for its mesh, ` +
      `and this page is to take at most ${allowed}: build the model with fewer faces (\`lumatlas build --faces\`), or ` +
      `add \`?memory=${enough}\` to this page's address.`;
}

function connect(viewer) {
  const page = new Interface({
    mode: (mode) => {
      viewer.setMode(mode);
      page.showMode(viewer.mode);
    },
    quality: (quality) => viewer.setQuality(quality),
    jump: (slot) => {
      const {pose, fov} = viewer.navigation.poseOfView(slot, viewer.canvas.width, viewer.canvas.height);
      viewer.navigation.goTo(pose, fov, performance.now());
    },
    save: async () => save(await viewer.screenshot(), 'lumatlas.png'),
    memory: () => {
      if (!viewer.renderer?.photographs) return '';
      const {bytes, allowed, photographs, room, texels} = viewer.gpuMemory();
      const mebibytes = [bytes, allowed].map((value) => Math.round(value / MEBIBYTE));
      return `${photographs} of ${viewer.scene.views.filter(Boolean).length} photographs are on the GPU, which has ` +
          `room for ${room}: ${mebibytes[0]} of ${mebibytes[1]} MiB, texels in the form ${texels}.`;
    },
    hold: () => {
      const {hold} = viewer.navigation;
      hold.on = !hold.on;
      page.showHold(hold.on);
    },
    walk: () => {
      viewer.navigation.toggleOrbits();
      page.showOrbits(viewer.navigation.orbits);
    },
  });
  viewer.crowded = (overrun) => page.showNotice(overrun ? memoryNotice(overrun) : '');
  viewer.missing = (line) => page.showLosses(line);
  viewer.progressed = () => {
    const {done, total, ended} = viewer.residents.progress();
    const scale = viewer.renderer.photographs.layout.scale;
    page.showProgress(`${done} of ${total} photographs`, done, total, ended);
    document.documentElement.dataset.photographs = `${done}/${total}`;
    document.documentElement.dataset.scale = scale.toFixed(3);
  };
  return page;
}

// Shows what becomes of a model, and says so; a page whose server has ended keeps what it has.
async function keepUp(viewer, page) {
  let ended = false;
  const tell = () => {
    page.showNote(ended ? 'The program that made this does not answer.' :
                          `${viewer.scene.views.filter(Boolean).length} photographs, more may come`);
  };
  const {followed} = viewer;
  viewer.followed = () => {
    followed();
    tell();
  };
  viewer.followed();
  await viewer.keepUp((silent) => {
    if (silent === ended) return;
    ended = silent;
    tell();
  });
  page.showNote('');
  document.documentElement.dataset.state = 'last';
}

async function main() {
  const canvas = document.getElementById('picture');
  const asked = new URLSearchParams(location.search);
  const wanted = Number(asked.get('memory'));
  let page = null;
  const fail = (error) => {
    document.documentElement.dataset.state = 'failed';
    (page ?? new Interface({})).showFailure(error.message);
    console.error(error);
  };
  try {
    const {live} = document.documentElement.dataset;
    const viewer = new Viewer(canvas, {
      base: document.baseURI, memory: wanted > 0 ? wanted : MEMORY_MIB, texels: asked.get('texels') ?? 'auto', live,
    });
    page = connect(viewer);
    viewer.failed = fail;
    page.showProgress(live ? 'waits for the first photographs' : 'the mesh', 0, 1);
    const scene = await viewer.open();
    if (scene.poster) page.showPoster(viewer.files, scene.poster);
    viewer.followed = () => {
      page.showThumbnails(viewer.scene, viewer.files);
      page.showOrbits(viewer.navigation.orbits);
      document.documentElement.dataset.version = viewer.scene.version;
    };
    viewer.followed();
    page.showMode(viewer.mode);
    page.showHold(viewer.navigation.hold.on);
    linkAddress(viewer, page);
    const controls = new Controls(canvas, viewer.navigation, (x, y) => viewer.pick(x, y), () => viewer.moved());
    new ResizeObserver(() => viewer.resize()).observe(canvas);
    const lost = 'The browser has taken the GPU away: load the page again.';
    canvas.addEventListener('webglcontextlost', () => fail(new Error(lost)));
    viewer.run((seconds) => {
      if (viewer.hasMesh) page.hidePoster();
      return controls.advance(seconds);
    });
    window.lumatlas = viewer;  // for the console, and for pages around this one
    await viewer.load();
    document.documentElement.dataset.state = 'complete';
    if (live) await keepUp(viewer, page);
  } catch (error) {
    fail(error);
  }
}

// Only where the page is this site's own.
if (document.getElementById('picture')) main();
