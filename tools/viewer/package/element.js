// SPDX-License-Identifier: GPL-3.0-or-later
// Implements <lumatlas-viewer src="folder/">, which shows a model in any page.
import {ENGLISH, Texts, languageOf} from '../page/texts/texts.js';
import {hasHeadset} from '../page/headset/headset.js';
import {MARKS_STYLE, OwnerMarks} from './owner_marks.js';
import {ShownModel} from './shown_model.js';
import {cameraOf} from './view_poses.js';
/** @import {WantedCamera} from './view_poses.js' */
/** @import {Vector} from '../page/types.d.ts' */

const STYLE = `
:host { display: block; position: relative; overflow: hidden; aspect-ratio: 4 / 3; background: #2b3038; }
:host([hidden]) { display: none; }
#inside { all: initial; position: absolute; inset: 0; display: block; font: 13px/1.4 system-ui, sans-serif;
  color: #eee; }
[hidden] { display: none !important; }
canvas { position: absolute; inset: 0; display: block; width: 100%; height: 100%; touch-action: none; cursor: grab; }
canvas:active { cursor: grabbing; }
canvas:focus-visible { outline: 2px solid #9cf; outline-offset: -2px; }
canvas.still { pointer-events: none; }
#poster { position: absolute; inset: 0; width: 100%; height: 100%; object-fit: contain; pointer-events: none; }
progress { position: absolute; inset: auto 0 0; width: 100%; height: 4px; appearance: none; border: none;
  background: #0006; pointer-events: none; }
progress::-webkit-progress-bar { background: #0006; }
progress::-webkit-progress-value { background: #9cf; }
progress::-moz-progress-bar { background: #9cf; }
#line { position: absolute; inset: 8px 8px auto; margin: 0; padding: 4px 8px; background: #000b; border-radius: 4px;
  border-left: 3px solid #fc6; overflow-wrap: anywhere; pointer-events: none; }
#vr { position: absolute; inset: auto 8px 12px auto; min-width: 44px; height: 34px; padding: 0 10px; font: inherit;
  color: inherit; background: #16181cd0; border: none; border-radius: 8px; cursor: pointer; }
#vr[aria-pressed="true"] { color: #8cf; }
#vr:focus-visible { outline: 2px solid #9cf; }
`;
const NOT_OPEN = 'the model is not open yet: wait for load(), or for the event "load"';

// Imported where there are no elements, as when a page is made on a server, this module does nothing.
const Base = globalThis.HTMLElement ?? /** @type {typeof HTMLElement} */ (/** @type {unknown} */ (class {}));

/**
 * @template {keyof HTMLElementTagNameMap} Tag
 * @param {Tag} tag
 * @param {Partial<HTMLElementTagNameMap[Tag]>} properties
 */
const made = (tag, properties = {}) => Object.assign(document.createElement(tag), properties);

// Returns a colour of CSS as red, green, blue in [0, 1]; null: it is none.
/** @param {string} text @returns {Vector | null} */
function colorOfText(text) {
  if (!CSS.supports('color', text)) return null;
  const context = new OffscreenCanvas(1, 1).getContext('2d');
  if (!context) return null;
  context.fillStyle = text;
  context.fillRect(0, 0, 1, 1);
  return [...context.getImageData(0, 0, 1, 1).data].slice(0, 3).map((level) => level / 255);
}

export class LumatlasViewerElement extends Base {
  static observedAttributes = [
    'src', 'memory', 'owner', 'lang', 'drift', 'quality', 'mode', 'controls', 'hold', 'poster', 'background', 'vr',
  ];

  constructor() {
    super();
    const root = this.attachShadow({mode: 'open'});
    const sheet = new CSSStyleSheet();
    sheet.replaceSync(STYLE + MARKS_STYLE);
    root.adoptedStyleSheets = [sheet];
    this._inside = made('div', {id: 'inside'});
    this._poster = made('img', {id: 'poster', alt: '', hidden: true});
    this._bar = made('progress', {hidden: true});
    this._bar.setAttribute('part', 'progress');
    this._line = made('p', {id: 'line', hidden: true});
    this._line.setAttribute('role', 'status');
    this._line.setAttribute('part', 'message');
    this._layer = made('div', {id: 'marks'});
    this._vr = made('button', {id: 'vr', hidden: true});
    this._vr.setAttribute('part', 'vr');
    this._vr.addEventListener('click', () => this._toggleVr());
    this._inside.append(this._poster, this._layer, this._vr, this._bar, this._line);
    root.append(this._inside);
    // A page scrolls on under the wheel until the visitor has turned to the model.
    this._inside.addEventListener('wheel', (event) => {
      if (!root.activeElement) event.stopPropagation();
    }, {capture: true});
    /** @type {ShownModel | null} */
    this._shown = null;
    /** @type {Promise<void> | null} */
    this._loading = null;
    this._moved = this._begins = false;
    this._texts = ENGLISH;
    /** @type {OwnerMarks | null} */
    this._marks = null;
  }

  connectedCallback() {
    if (!this._shown) this._beginSoon();
  }

  // An element that is only moved within its document keeps its model.
  disconnectedCallback() {
    queueMicrotask(() => {
      if (!this.isConnected) this._end();
    });
  }

  /** @param {string} name @param {string | null} before @param {string | null} value */
  attributeChangedCallback(name, before, value) {
    if (['src', 'memory', 'owner', 'lang'].includes(name)) {
      if (before !== value || name === 'src') this._beginSoon();
    } else if (name === 'poster') {
      this._showPoster();
    } else if (name === 'vr') {
      this._offerVr();
    } else if (name === 'drift') {
      if (value === null || value === 'off') this._shown?.drift?.end();
    } else if (this._shown?.viewer.model) {
      this._apply(name);
    }
  }

  get src() {
    return this.getAttribute('src') ?? '';
  }

  set src(source) {
    this.setAttribute('src', source);
  }

  // Shows another model. Resolves once every file is loaded that the server has. Throws if there is no model.
  /** @param {string} source @returns {Promise<void>} */
  load(source) {
    if (!this.isConnected) return Promise.reject(new Error('the element is not in a document, where it would load'));
    this.src = source;
    this._begin();
    return this._loading ?? Promise.reject(new Error('load() needs the address of a model'));
  }

  // Goes to a photograph, by name or number, or to a camera. Resolves on arrival, or when the visitor goes elsewhere.
  /** @param {string | number | WantedCamera} target @param {{duration?: number}} options */
  async goTo(target, {duration} = {}) {
    await this._open.goTo(target, duration);
  }

  async screenshot() {
    return this._open.screenshot();
  }

  async coverage() {
    return this._open.coverage();
  }

  // Shows the model in the visitor's headset. A click must call it, or browsers refuse.
  async enterVr() {
    if (!navigator.xr) throw new Error('this browser has no WebXR');
    await this._open.headset.begin();
  }

  exitVr() {
    this._shown?.headset.end();
  }

  get errors() {
    return this._shown ? [...this._shown.errors] : [];
  }

  get views() {
    return this._shown ? this._shown.names : [];
  }

  // What the owner's file says; null: there is no model yet.
  get owner() {
    if (!this._shown?.viewer.model) return null;
    const {title, description, unit, annotations} = this._shown.owner;
    return {title, description, unit, annotations};
  }

  get camera() {
    const {pose, fov} = this._open.viewer.navigation;
    return cameraOf(pose, fov);
  }

  /** @param {WantedCamera} camera */
  set camera(camera) {
    this._open.goTo(camera, 0);
  }

  get _open() {
    if (!this._shown?.viewer.model) throw new Error(NOT_OPEN);
    return this._shown;
  }

  // Begins once for all attributes that are set together.
  _beginSoon() {
    this._begins = true;
    queueMicrotask(() => {
      if (this._begins) this._begin();
    });
  }

  _begin() {
    this._begins = false;
    this._end();
    if (!this.isConnected || this.src === '') return;
    // The element's language, else that of what it stands in, else the visitor's.
    const around = /** @type {HTMLElement | null} */ (this.closest('[lang]'))?.lang;
    this._texts = new Texts(languageOf([this.lang, around, ...navigator.languages]));
    const canvas = made('canvas', {tabIndex: 0});
    canvas.setAttribute('role', 'application');
    canvas.setAttribute('aria-label', this._texts.say('scene'));
    this._inside.prepend(canvas);
    this._canvas = canvas;
    this._showPoster();
    this._bar.hidden = false;
    this._bar.removeAttribute('value');
    this._loading = this._load(canvas);
    this._loading.catch(() => {});  // the event "error" tells of it
  }

  /** @param {HTMLCanvasElement} canvas */
  async _load(canvas) {
    const memory = Number(this.getAttribute('memory'));
    const options = {
      memory: memory > 0 ? memory : null, owner: this.getAttribute('owner') || null,
      texts: this._texts, drifts: !['off', null].includes(this.getAttribute('drift')),
    };
    try {
      this._shown = new ShownModel(canvas, this.src, options, this._listener());
    } catch (error) {
      const message = this._texts.of(error);
      this._showLine(message);
      queueMicrotask(() => this._tell('error', {message, final: true}));
      throw error;
    }
    const shown = this._shown;
    this._apply('controls');
    await shown.load();
    if (shown === this._shown) this._tell('load');
  }

  _listener() {
    let opened = false;
    return {
      drawn: () => {
        if (!opened) this._start();
        opened = true;
        this._marks?.follow();
        if (this._shown?.viewer.hasMesh) this._poster.hidden = true;
        if (this._moved) this._tell('viewchange', this.camera);
        this._moved = false;
      },
      moved: () => {
        this._moved = true;
        if (!opened) this._showPoster();
      },
      /** @param {number} came @param {number} all */
      begun: (came, all) => Object.assign(this._bar, {max: all, value: came}),
      /** @param {number} done @param {number} total @param {boolean} ended */
      progressed: (done, total, ended) => {
        Object.assign(this._bar, {max: Math.max(1, total), value: done, hidden: ended});
        this._tell('progress', {done, total});
      },
      /** @param {string} message @param {boolean} final */
      failed: (message, final) => {
        if (final) this._bar.hidden = true;
        this._tell('error', {message, final});
      },
      /** @param {string} line */
      missing: (line) => this._showLine(line),
      /** @param {boolean} shows */
      headset: (shows) => {
        this._vr.setAttribute('aria-pressed', String(shows));
        this._tell('vr', {shows});
      },
    };
  }

  // The model is open: its attributes and what its owner says of it count from now on.
  _start() {
    for (const name of ['quality', 'mode', 'hold', 'background']) this._apply(name);
    const {viewer, owner} = this._open;
    const label = this._texts.say('titledScene', {title: owner.title, scene: {key: 'scene'}});
    if (owner.title) viewer.canvas.setAttribute('aria-label', label);
    this._offerVr();
    if (owner.annotations.length > 0) this._marks = new OwnerMarks(viewer, this._layer, owner.annotations);
  }

  // Shows the button for the headset, where the page wants it and there is one.
  async _offerVr() {
    const shown = this._shown;
    const isWanted = !['off', null].includes(this.getAttribute('vr')) && Boolean(shown?.viewer.model);
    const isThere = isWanted && await hasHeadset();
    if (shown !== this._shown) return;
    this._vr.textContent = this._texts.say('headset');
    this._vr.title = this._texts.say('showsInHeadset');
    this._vr.setAttribute('aria-pressed', String(Boolean(shown?.headset.session)));
    this._vr.hidden = !isThere;
  }

  async _toggleVr() {
    if (this._shown?.headset.session) return this.exitVr();
    try {
      await this.enterVr();
    } catch (error) {
      this._showLine(this._texts.say('headsetFails', {why: this._texts.of(error)}));
    }
  }

  // Ends the model, and deletes what it has on the GPU.
  _end() {
    this._marks?.end();
    this._marks = null;
    this._shown?.close();
    this._shown = this._loading = null;
    this._canvas?.remove();
    this._canvas = undefined;
    this._poster.hidden = this._bar.hidden = this._vr.hidden = true;
    this._showLine('');
  }

  // Applies an attribute's value.
  /** @param {string} name */
  _apply(name) {
    const value = this.getAttribute(name) ?? '';
    const viewer = this._shown?.viewer;
    if (!viewer) return;
    if (name === 'controls') {
      viewer.canvas.classList.toggle('still', value === 'none');
      viewer.canvas.tabIndex = value === 'none' ? -1 : 0;
    } else if (name === 'quality') {
      viewer.setQuality(value);
    } else if (name === 'mode') {
      viewer.setMode(value);
    } else if (name === 'hold') {
      viewer.navigation.hold.on = value !== 'off';
    } else if (name === 'background') {
      const color = colorOfText(value);
      if (color) viewer.background = {above: color, below: color, continues: false};
      viewer.invalidate();
    }
  }

  // Shows a picture until the first frame: the one that the page names, or the model's.
  _showPoster() {
    const viewer = this._shown?.viewer;
    if (viewer?.hasMesh) return;
    const given = this.getAttribute('poster');
    if (given) {
      this._poster.src = given;
    } else if (viewer?.model?.scene.poster) {
      viewer.files.show(this._poster, viewer.model.scene.poster);
    }
    this._poster.hidden = !given && !viewer?.model?.scene.poster;
  }

  /** @param {string} line */
  _showLine(line) {
    this._line.textContent = line;
    this._line.hidden = line === '';
  }

  /** @param {string} type @param {object} [detail] */
  _tell(type, detail) {
    this.dispatchEvent(new CustomEvent(type, {detail}));
  }
}
