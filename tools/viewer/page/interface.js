// SPDX-License-Identifier: GPL-3.0-or-later
// The elements around the picture: progress, buttons, thumbnails, legend, messages.
import {button, element, part} from './elements.js';
import {putText} from './texts/fill.js';
/** @import {SiteFiles} from './reading/site_files.js' */
/** @import {Texts} from './texts/texts.js' */
/** @import {Actions, Mode, SaidKey, Scene, View} from './types.d.ts' */

/** @type {Record<Mode, SaidKey | null>} */
const LEGENDS = {
  picture: null, winner: 'ofWinner', weights: 'ofWeights', coverage: 'ofCoverage', geometry: 'ofGeometry',
  colours: 'ofColours',
};

// Buttons that need a model.
const OF_A_MODEL = ['walk', 'hold', 'first-view', 'link', 'save', 'more'];

const LINK_TOLD_MS = 2500;  // how long a button says that the link is copied

export class Interface {
  /** @param {Texts} texts @param {Actions} actions */
  constructor(texts, actions) {
    this.texts = texts;
    this.actions = actions;
    this.notice = '';
    const mode = element('mode', HTMLSelectElement);
    const quality = element('quality', HTMLSelectElement);
    mode.addEventListener('change', () => actions.mode(mode.value));
    quality.addEventListener('change', () => actions.quality(quality.value));
    button('save').addEventListener('click', () => actions.save());
    button('walk').addEventListener('click', () => actions.walk());
    button('hold').addEventListener('click', () => actions.hold());
    button('full').addEventListener('click', () => this.toggleFullScreen());
    button('link').addEventListener('click', () => this.copyLink());
    button('views').addEventListener('click', () => this.toggleThumbnails());
    button('help').addEventListener('click', () => this.showHelp());
    button('understood').addEventListener('click', () => {
      part('notice').hidden = true;
    });
    addEventListener('keydown', (event) => this.pressed(event));
    button('full').hidden = !document.fullscreenEnabled;
  }

  // The model is open: buttons that need it work from now on.
  showModel() {
    for (const id of OF_A_MODEL) button(id).disabled = false;
  }

  // Presses the button whose key it is.
  /** @param {KeyboardEvent} event */
  pressed({key, target, ctrlKey, metaKey, altKey}) {
    if (ctrlKey || metaKey || altKey) return;
    if (target instanceof HTMLElement && target.matches('input, textarea, select, dialog *')) return;
    /** @type {NodeListOf<HTMLButtonElement>} */
    const buttons = document.querySelectorAll('nav button[aria-keyshortcuts]:not([hidden])');
    [...buttons].find((each) => each.getAttribute('aria-keyshortcuts') === key.toUpperCase())?.click();
  }

  showHelp() {
    part('memory').textContent = this.actions.memory();
    const keys = element('keys', HTMLDialogElement);
    if (!keys.open) keys.showModal();
  }

  toggleFullScreen() {
    if (document.fullscreenElement) return document.exitFullscreen();
    return document.documentElement.requestFullscreen().catch(() => {});  // the browser may say no
  }

  // Copies the address of this view, where the browser lets it.
  async copyLink() {
    const shown = button('link');
    this.actions.writeAddress();
    try {
      await navigator.clipboard.writeText(location.href);
      this.nameButton(shown, 'linkCopied');
    } catch {
      this.nameButton(shown, 'linkIsAddress');
    }
    shown.classList.add('tells');
    setTimeout(() => {
      shown.classList.remove('tells');
      this.nameButton(shown, 'copyLink');
    }, LINK_TOLD_MS);
  }

  // The name is read to those who hear the page, and is shown beside the button to those who see it.
  /** @param {HTMLButtonElement} shown @param {SaidKey} key */
  nameButton(shown, key) {
    const name = shown.querySelector('.name');
    if (name) name.textContent = this.texts.say(key);
  }

  // Says what a button's state means.
  /** @param {string} id @param {SaidKey} key */
  explain(id, key) {
    const said = this.texts.say(key);
    button(id).setAttribute('aria-description', said);
    button(id).querySelector('.name')?.setAttribute('data-hint', said);
  }

  toggleThumbnails() {
    const strip = part('thumbnails');
    strip.hidden = !strip.hidden;
    button('views').setAttribute('aria-expanded', String(!strip.hidden));
  }

  /** @param {Scene} scene @param {SiteFiles} files */
  showThumbnails(scene, files) {
    const strip = part('thumbnails');
    const there = [...strip.querySelectorAll('button')];
    const known = new Map(there.map((shown) => [shown.dataset.content, shown]));
    const buttons = scene.views.flatMap((view, slot) => {
      return view ? [known.get(`${slot} ${view.thumbnail}`) ?? this.thumbnail(view, slot, files)] : [];
    });
    if (buttons.length !== there.length || buttons.some((shown, i) => shown !== there[i])) {
      strip.replaceChildren(...buttons);
    }
  }

  /** @param {View} view @param {number} slot @param {SiteFiles} files */
  thumbnail(view, slot, files) {
    const shown = document.createElement('button');
    const image = document.createElement('img');
    image.loading = 'lazy';
    files.show(image, view.thumbnail);
    image.alt = '';
    shown.title = view.name;
    shown.dataset.slot = String(slot);
    shown.dataset.content = `${slot} ${view.thumbnail}`;
    shown.setAttribute('aria-label', this.texts.say('photographNamed', {name: view.name}));
    shown.append(image);
    shown.addEventListener('click', () => this.actions.jump(slot));
    return shown;
  }

  /** @param {Mode} mode */
  showMode(mode) {
    element('mode', HTMLSelectElement).value = mode;
    const legend = LEGENDS[mode];
    part('legend').textContent = legend ? this.texts.say(legend) : '';
    part('legend').hidden = legend === null;
  }

  /** @param {boolean} orbits */
  showOrbits(orbits) {
    button('walk').setAttribute('aria-pressed', String(!orbits));
    this.explain('walk', orbits ? 'turnsAround' : 'turnsHead');
  }

  /** @param {boolean} on */
  showHold(on) {
    button('hold').setAttribute('aria-pressed', String(on));
    this.explain('hold', on ? 'returns' : 'goesAnywhere');
  }

  // `done` of `total` photographs are there. `ended`: there is nothing to wait for.
  /** @param {string} text @param {number} done @param {number} total @param {boolean} ended */
  showProgress(text, done, total, ended = done >= total) {
    const bar = element('progress', HTMLProgressElement);
    bar.max = Math.max(total, 1);
    bar.value = done;
    bar.hidden = ended;
    part('status').textContent = ended ? '' : text;
  }

  // Shows in one line what could not be loaded; '': nothing is missing.
  /** @param {string} line */
  showLosses(line) {
    this.showLine('losses', line);
  }

  /** @param {boolean} lost */
  showGpuLost(lost) {
    this.showLine('gpu', lost ? this.texts.say('gpuLost') : '');
  }

  /** @param {string} id @param {string} line */
  showLine(id, line) {
    const shown = part(id);
    shown.textContent = shown.title = line;
    shown.hidden = line === '';
  }

  /** @param {string} text */
  showNote(text) {
    part('status').textContent = text;
  }

  // Until it is understood; '': there is nothing to say any more. What is to be typed stands between ` and `.
  /** @param {string} text */
  showNotice(text) {
    if (this.notice === text) return;
    this.notice = text;
    putText(part('notice-text'), text);
    part('notice').hidden = text === '';
  }

  // A site's page names its poster itself, which is there before this script is.
  /** @param {SiteFiles} files @param {string} name */
  showPoster(files, name) {
    const poster = element('poster', HTMLImageElement);
    if (!poster.hidden) return;
    files.show(poster, name);
    poster.hidden = false;
  }

  hidePoster() {
    part('poster').hidden = true;
  }
}

// Shows why there is no picture, instead of it and of what would do nothing any more.
/** @param {string} text */
export function showFailure(text) {
  part('message').textContent = text;
  part('message').hidden = false;
  for (const tag of ['nav', 'footer']) document.querySelector(tag)?.setAttribute('hidden', '');
  part('progress').hidden = true;
  part('status').textContent = '';
}
