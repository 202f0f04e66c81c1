// SPDX-License-Identifier: GPL-3.0-or-later
// The page of a site. For other pages: `openModel(canvas, options)` shows a site's model in a canvas of their own.
import {parseAddress, printAddress} from './address.js';
import {Comparison} from './over/comparing.js';
import {Drift} from './drift.js';
import {button, part} from './elements.js';
import {Headset} from './headset/headset.js';
import {connectHeadset} from './headset/headset_button.js';
import {interact} from './interaction.js';
import {Interface, showFailure} from './interface.js';
import {Marks} from './over/marks.js';
import {Measuring} from './over/measuring.js';
import {PageEditor} from './owner/editor.js';
import {OwnerPage} from './owner/owner_page.js';
import {readPageFile} from './owner/read_page_file.js';
import {Panels} from './panels.js';
import {KeyFrames} from './path/key_frames.js';
import {save} from './saving.js';
import {QuietControls} from './quiet_controls.js';
import {viewsOf} from './reading/model.js';
import {clusteredFaces} from './drawing/clustered_faces.js';
import {boundOfWeight} from './drawing/ranked_references.js';
import {texelForm} from './drawing/photograph_forms.js';
import {fillTexts} from './texts/fill.js';
import {Texts, languageOf} from './texts/texts.js';
import {MEBIBYTE, Viewer, defaultMemory} from './viewer.js';
import {Walking} from './walking.js';
/** @import {LengthUnit, Overrun, PageFile, ViewerOptions} from './types.d.ts' */

export {Viewer, boundOfWeight, clusteredFaces, texelForm};

const WRITE_ADDRESS_MS = 200;

// Shows the model of the site whose folder is `options.base`. Resolves once it is drawn from what has come: `viewer` is
// what draws it, `loaded` resolves when all is there that can be had, and `close` ends it. Throws where the browser has
// no WebGL 2 or the site is of another format.
/** @param {HTMLCanvasElement} canvas @param {Partial<ViewerOptions> & {base: string}} options */
export async function openModel(canvas, options) {
  const viewer = new Viewer(canvas, {memory: defaultMemory(Boolean(options.live)), texels: 'auto', ...options});
  await viewer.open();
  interact(viewer);
  return {viewer, loaded: viewer.load(), close: () => viewer.close()};
}

/** @param {Viewer} viewer */
function writeAddress({navigation, mode}) {
  history.replaceState(null, '', printAddress({pose: navigation.pose, fov: navigation.fov, mode}));
}

// Address and view follow each other, without an entry in the history for each movement.
/** @param {Viewer} viewer @param {Interface} page */
function linkAddress(viewer, page) {
  const read = (/** @type {string} */ address) => {
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
    writeAddress(viewer);
  };
  read(location.href);
  viewer.changed = () => {
    timer ||= setTimeout(write, WRITE_ADDRESS_MS);
  };
  addEventListener('hashchange', (event) => {
    if (read(event.newURL)) viewer.invalidate();
  });
}

/** @param {Texts} texts @param {Overrun} overrun */
const memoryNotice = (texts, {all, mesh, allowed, enough}) =>
  texts.say('tooLarge', {all: Math.ceil(all), mesh: Math.round(mesh), allowed, enough});

/** @param {Viewer} viewer */
function memoryLine(viewer) {
  if (!viewer.isOpen() || !viewer.renderer.photographs) return '';
  const {bytes, allowed, photographs, room, texels} = viewer.gpuMemory();
  const mebibytes = (/** @type {number} */ value) => Math.round(value / MEBIBYTE);
  return viewer.texts.say('memory', {
    there: photographs, all: viewsOf(viewer.scene).length, room, bytes: mebibytes(bytes), allowed: mebibytes(allowed),
    form: texels,
  });
}

/** @param {Viewer} viewer */
function connect(viewer) {
  const page = new Interface(viewer.texts, {
    mode: (mode) => {
      viewer.setMode(mode);
      page.showMode(viewer.mode);
    },
    quality: (quality) => viewer.setQuality(quality),
    jump: (slot) => {
      const place = viewer.navigation.poseOfView(slot, viewer.canvas.width, viewer.canvas.height);
      if (place) viewer.navigation.goTo(place.pose, place.fov, performance.now());
    },
    save: async () => save(await viewer.screenshot(), 'lumatlas.png'),
    memory: () => memoryLine(viewer),
    writeAddress: () => writeAddress(viewer),
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
  viewer.crowded = (overrun) => page.showNotice(overrun ? memoryNotice(viewer.texts, overrun) : '');
  viewer.missing = (line) => page.showLosses(line);
  viewer.gpuLost = (lost) => {
    page.showGpuLost(lost);
    document.documentElement.dataset.gpu = lost ? 'lost' : 'there';
  };
  viewer.begun = (came, all) => page.showProgress(viewer.texts.say('theMesh'), came, all, false);
  viewer.progressed = () => {
    const {photographs} = viewer.renderer;
    if (!photographs) return;
    const {done, total, ended} = viewer.residents.progress();
    page.showProgress(viewer.texts.say('loaded', {done, total}), done, total, ended);
    document.documentElement.dataset.photographs = `${done}/${total}`;
    document.documentElement.dataset.scale = photographs.layout.scale.toFixed(3);
  };
  return page;
}

// Shows what becomes of a model, and says so; a page whose server has ended keeps what it has.
/** @param {Viewer} viewer @param {Interface} page */
async function keepUp(viewer, page) {
  let ended = false;
  const tell = () => {
    const {texts, scene} = viewer;
    page.showNote(ended ? texts.say('programSilent') : texts.say('more', {count: viewsOf(scene).length}));
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

// Shows an open model in the page, and what its owner says of it.
/** @param {Viewer} viewer @param {Interface} page @param {PageFile} pageFile @param {URLSearchParams} asked */
function showModel(viewer, page, pageFile, asked) {
  const {scene} = viewer;
  if (scene.poster) page.showPoster(viewer.files, scene.poster);
  viewer.followed = () => {
    page.showThumbnails(viewer.scene, viewer.files);
    page.showOrbits(viewer.navigation.orbits);
    document.documentElement.dataset.version = String(viewer.scene.version);
  };
  viewer.followed();
  page.showMode(viewer.mode);
  page.showHold(viewer.navigation.hold.on);
  page.showModel();
  const tools = startTools(viewer, pageFile);
  button('walking').addEventListener('click', () => {
    tools.walking.turn(!tools.walking.isOn);
    button('walking').setAttribute('aria-pressed', String(tools.walking.isOn));
    page.showOrbits(viewer.navigation.orbits);
  });
  tools.owner.goToFirstView();
  viewer.quietly(connectHeadset(tools.headset, viewer.texts));
  linkAddress(viewer, page);
  const isDrifting = asked.get('drift') !== 'off' && !viewer.live && !parseAddress(location.hash);
  const drift = isDrifting ? new Drift(viewer, window) : null;
  Object.assign(window, {lumatlasTools: {...tools, drift, quiet: new QuietControls()}});  // for the console
  interact(viewer, () => {
    if (viewer.hasMesh) page.hidePoster();
    for (const tool of [tools.path, tools.comparison, tools.marks]) tool.follow();
  }, drift);
}

// The unit of lengths in a model: metres where it has a place on the Earth.
/** @param {Texts} texts @returns {LengthUnit} */
const lengthUnit = (texts) => ({name: document.documentElement.dataset.unit ?? texts.say('sceneUnits'), length: 1});

// Connects the tools that lie over the picture and follow its camera.
/** @param {Viewer} viewer @param {PageFile} pageFile */
function startTools(viewer, pageFile) {
  new Panels().add({button: button('more'), panel: part('tools'), toggled: () => {}});
  const marks = new Marks(viewer, part('marks'));
  viewer.finished = () => marks.look();
  const measuring = new Measuring(viewer, marks, lengthUnit(viewer.texts));
  const owner = new OwnerPage(viewer, marks, measuring, pageFile);
  button('first-view').addEventListener('click', () => owner.flyToFirstView());
  const editor = new PageEditor(viewer, owner);
  const path = new KeyFrames(viewer);
  marks.moved = () => {
    measuring.drawLine();
    path.drawLine();
    editor.follow();
  };
  const panels = new Panels();
  panels.add({button: button('about'), panel: part('about-panel'), toggled: () => {}});
  owner.annotations.opening = () => {
    if (!part('about-panel').hidden) panels.closeAll();
  };
  panels.add({button: button('path'), panel: part('pathing'), toggled: (open) => path.turn(open)});
  panels.add({button: button('edit'), panel: part('editing'), toggled: (open) => editor.turn(open)});
  panels.add({button: button('measure'), panel: part('measuring'), toggled: (open) => measuring.turn(open)});
  const headset = new Headset(viewer, () => measuring.unit);
  const [comparison, walking] = [new Comparison(viewer), new Walking(viewer)];
  return {comparison, marks, measuring, path, owner, editor, walking, headset};
}

/** @param {HTMLCanvasElement} canvas */
async function main(canvas) {
  const asked = new URLSearchParams(location.search);
  const wanted = Number(asked.get('memory'));
  const texts = new Texts(languageOf([asked.get('lang'), ...navigator.languages]));
  fillTexts(texts);
  const fail = (/** @type {unknown} */ error) => {
    document.documentElement.dataset.state = 'failed';
    showFailure(texts.of(error));
    console.error(error);
  };
  try {
    const {live, model, pageFile} = document.documentElement.dataset;
    const memory = wanted > 0 ? wanted : defaultMemory(Boolean(live));
    const options = {memory, texels: asked.get('texels') ?? 'auto', live, model, texts};
    const viewer = new Viewer(canvas, {base: document.baseURI, ...options});
    const page = connect(viewer);
    viewer.failed = fail;
    page.showProgress(texts.say(live ? 'waits' : 'theMesh'), 0, 1);
    const [said] = await Promise.all([readPageFile(viewer.files, pageFile), viewer.open()]);
    page.showLine('page-file', said.complaint ? texts.of(said.complaint) : '');
    showModel(viewer, page, said.file, asked);
    Object.assign(window, {lumatlas: viewer});  // for the console, and for pages around this one
    await viewer.load();
    document.documentElement.dataset.state = 'complete';
    if (live) await keepUp(viewer, page);
  } catch (error) {
    fail(error);
  }
}

// Only where the page is this site's own.
const picture = document.getElementById('picture');
if (picture instanceof HTMLCanvasElement) main(picture);
