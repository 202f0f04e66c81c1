// SPDX-License-Identifier: GPL-3.0-or-later
// Lets the owner edit page.json in the page, and hands it out as a download. The model is not touched.
import {quaternionOf, row, times} from '../camera.js';
import {actionButton, button, element, part} from '../elements.js';
import {SurfaceTaps} from '../over/surface_taps.js';
import {save} from '../saving.js';
import {CropControls} from './crop_controls.js';
import {PAGE_FILE_NAME, PageFileError, parsePageFile, printPageFile} from './page_file.js';
/** @import {OwnerPage} from './owner_page.js' */
/** @import {Viewer} from '../viewer.js' */
/** @import {Annotation, HiddenBall, PageFile, SavedView, SurfacePoint} from '../types.d.ts' */

const BALL_SHARE = 0.05;      // first radius of a hidden part, by the typical depth
const LARGEST_BALL = 1;       // largest, by the typical depth
const BALL_STEPS = 200;

export class PageEditor {
  /** @param {Viewer} viewer @param {OwnerPage} page */
  constructor(viewer, page) {
    this.viewer = viewer;
    this.page = page;
    this.isOpen = false;
    this.isChanged = false;
    /** @type {'annotation' | 'hidden' | null} */
    this.placing = null;  // what the next click on the surface makes
    this.taps = new SurfaceTaps(viewer, (point) => this.place(point));
    this.crop = new CropControls(viewer, (crop) => this.change({crop}));
    this.connect();
    addEventListener('beforeunload', (event) => {
      if (this.isChanged) event.preventDefault();
    });
  }

  get file() {
    return this.page.file;
  }

  connect() {
    const title = element('edit-title', HTMLInputElement);
    const description = element('edit-description', HTMLTextAreaElement);
    title.addEventListener('input', () => this.change({title: title.value}));
    description.addEventListener('input', () => this.change({description: description.value}));
    button('edit-view').addEventListener('click', () => this.change({view: this.savedView()}));
    button('edit-no-view').addEventListener('click', () => this.change({view: null}));
    button('edit-up').addEventListener('click', () => {
      this.change({up: times(row(this.viewer.navigation.pose.rotation, 1), -1)});
    });
    button('edit-no-up').addEventListener('click', () => this.change({up: null}));
    for (const id of ['edit-unit', 'edit-length']) {
      element(id, HTMLInputElement).addEventListener('input', () => this.takeUnit());
    }
    button('edit-annotate').addEventListener('click', () => this.startPlacing('annotation'));
    button('edit-hide').addEventListener('click', () => this.startPlacing('hidden'));
    button('edit-save').addEventListener('click', () => this.download());
    const chosen = element('edit-open', HTMLInputElement);
    chosen.addEventListener('change', () => {
      const [file] = chosen.files ?? [];
      chosen.value = '';
      if (file) this.viewer.quietly(this.openFile(file));
    });
  }

  /** @param {boolean} open */
  turn(open) {
    this.isOpen = open;
    this.startPlacing(null);
    if (open) this.fill();
    this.crop.drawOutline(open);
  }

  // Called after marks have moved.
  follow() {
    this.crop.drawOutline(this.isOpen);
  }

  // Shows what is said now.
  fill() {
    const {title, description, unit, crop} = this.file;
    element('edit-title', HTMLInputElement).value = title;
    element('edit-description', HTMLTextAreaElement).value = description;
    element('edit-unit', HTMLInputElement).value = unit?.name ?? '';
    element('edit-length', HTMLInputElement).value = unit ? String(unit.length) : '';
    this.crop.set(crop);
    this.fillLists();
  }

  fillLists() {
    part('edit-annotations').replaceChildren(...this.file.annotations.map((_, i) => this.annotationEntry(i)));
    part('edit-hidden').replaceChildren(...this.file.hidden.map((ball, i) => this.ballEntry(ball, i)));
    this.tell();
  }

  // Says what is set and what the next click does.
  tell(complaint = '') {
    const {view, up} = this.file;
    button('edit-no-view').disabled = view === null;
    button('edit-no-up').disabled = up === null;
    const {texts} = this.viewer;
    let words = this.isChanged ? texts.say('unsaved') : '';
    if (this.placing === 'annotation') words = texts.say('clickAnnotation');
    if (this.placing === 'hidden') words = texts.say('clickHidden');
    part('edit-status').textContent = complaint || words;
  }

  /** @param {Partial<PageFile>} changes */
  change(changes) {
    this.isChanged = true;
    this.page.show({...this.file, ...changes});
    this.tell();
  }

  /** @returns {SavedView} */
  savedView() {
    const {pose, fov} = this.viewer.navigation;
    return {position: [...pose.position], turned: quaternionOf(pose.rotation), fov};
  }

  takeUnit() {
    const name = element('edit-unit', HTMLInputElement).value.trim();
    const length = Number(element('edit-length', HTMLInputElement).value.replace(',', '.'));
    this.change({unit: name && length > 0 ? {name, length} : null});
    if (name && !(length > 0)) this.tell(this.viewer.texts.say('badLength'));
  }

  /** @param {'annotation' | 'hidden' | null} kind */
  startPlacing(kind) {
    this.placing = kind;
    this.taps.turn(kind !== null);
    if (kind) this.viewer.canvas.focus({preventScroll: true});
    this.tell();
  }

  /** @param {SurfacePoint | null} tapped */
  place(tapped) {
    if (!tapped) return this.tell(this.viewer.texts.say('noSurface'));
    const {point} = tapped;
    const {placing, file} = this;
    this.startPlacing(null);
    if (placing === 'annotation') {
      const title = this.viewer.texts.say('annotation', {number: file.annotations.length + 1});
      const added = {point, title, text: '', view: this.savedView()};
      this.change({annotations: [...file.annotations, added]});
    } else {
      const radius = BALL_SHARE * this.viewer.navigation.typicalDepth;
      this.change({hidden: [...file.hidden, {center: point, radius}]});
    }
    this.fillLists();
    const list = part(placing === 'annotation' ? 'edit-annotations' : 'edit-hidden');
    list.lastElementChild?.querySelector('input')?.focus();
  }

  /** @param {number} i */
  annotationEntry(i) {
    const entry = document.createElement('li');
    const title = document.createElement('input');
    const text = document.createElement('textarea');
    const {annotations} = this.file;
    title.value = annotations[i].title;
    text.value = annotations[i].text;
    title.maxLength = 200;
    text.maxLength = 5000;
    text.rows = 2;
    const {texts} = this.viewer;
    const number = i + 1;
    title.setAttribute('aria-label', texts.say('titleOfAnnotation', {number}));
    text.setAttribute('aria-label', texts.say('textOfAnnotation', {number}));
    title.addEventListener('input', () => this.changeAnnotation(i, {title: title.value}));
    text.addEventListener('input', () => this.changeAnnotation(i, {text: text.value}));
    const buttons = document.createElement('div');
    buttons.className = 'row';
    buttons.append(
        actionButton(texts.say('setView'), () => this.changeAnnotation(i, {view: this.savedView()}),
                     texts.say('setViewOf', {number})),
        actionButton('↑', () => this.moveAnnotation(i), texts.say('moveAnnotationUp', {number})),
        actionButton(texts.say('delete'), () => this.deleteAnnotation(i), texts.say('deleteAnnotation', {number})));
    entry.append(title, text, buttons);
    return entry;
  }

  /** @param {number} i @param {Partial<Annotation>} changes */
  changeAnnotation(i, changes) {
    this.change({
      annotations: this.file.annotations.map((annotation, at) => at === i ? {...annotation, ...changes} : annotation),
    });
  }

  // Changes places with the one before; the first becomes the last.
  /** @param {number} i */
  moveAnnotation(i) {
    const annotations = [...this.file.annotations];
    const [moved] = annotations.splice(i, 1);
    annotations.splice(i > 0 ? i - 1 : annotations.length, 0, moved);
    this.change({annotations});
    this.fillLists();
  }

  /** @param {number} i */
  deleteAnnotation(i) {
    this.change({annotations: this.file.annotations.filter((_, at) => at !== i)});
    this.fillLists();
  }

  /** @param {HiddenBall} ball @param {number} i */
  ballEntry({radius}, i) {
    const entry = document.createElement('li');
    entry.className = 'row';
    const size = document.createElement('input');
    size.type = 'range';
    size.max = String(BALL_STEPS);
    const largest = LARGEST_BALL * this.viewer.navigation.typicalDepth;
    size.value = String(Math.round(BALL_STEPS * Math.sqrt(radius / largest)));
    const {texts} = this.viewer;
    const number = i + 1;
    size.setAttribute('aria-label', texts.say('sizeOfHidden', {number}));
    size.addEventListener('input', () => {
      const wanted = largest * (Number(size.value) / BALL_STEPS) ** 2;
      this.change({hidden: this.file.hidden.map((ball, at) => at === i ? {...ball, radius: wanted} : ball)});
    });
    entry.append(size, actionButton(texts.say('showAgain'), () => {
      this.change({hidden: this.file.hidden.filter((_, at) => at !== i)});
      this.fillLists();
    }, texts.say('showHiddenAgain', {number})));
    return entry;
  }

  download() {
    save(new Blob([printPageFile(this.file)], {type: 'application/json'}), PAGE_FILE_NAME);
    this.isChanged = false;
    this.tell(this.viewer.texts.say('pageFileSaved', {file: PAGE_FILE_NAME}));
  }

  // Takes a file of before in place of what is said now.
  /** @param {Blob} file */
  async openFile(file) {
    try {
      this.page.show(parsePageFile(await file.text()));
      this.isChanged = true;
      this.page.goToFirstView();
      this.viewer.moved();
      this.fill();
    } catch (error) {
      if (!(error instanceof PageFileError)) throw error;
      this.tell(this.viewer.texts.of(error));
    }
  }
}
