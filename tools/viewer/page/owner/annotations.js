// SPDX-License-Identifier: GPL-3.0-or-later
// The owner's annotations: numbered buttons at points of the surface. A click flies there and opens the text.
import {button, part} from '../elements.js';
import {flyToAnnotation} from './owners_views.js';
/** @import {Mark, Marks} from '../over/marks.js' */
/** @import {Viewer} from '../viewer.js' */
/** @import {Annotation} from '../types.d.ts' */

export class Annotations {
  /** @param {Viewer} viewer @param {Marks} marks */
  constructor(viewer, marks) {
    this.viewer = viewer;
    this.marks = marks;
    /** @type {Annotation[]} */
    this.all = [];
    /** @type {Mark[]} */
    this.shown = [];
    this.opening = () => {};  // before the text of one is shown
    this.opened = -1;  // number of the one whose text is open; -1: none
    button('annotation-before').addEventListener('click', () => this.open(this.opened - 1));
    button('annotation-after').addEventListener('click', () => this.open(this.opened + 1));
    button('annotation-close').addEventListener('click', () => this.close());
    part('annotation').addEventListener('keydown', (event) => {
      if (event.key !== 'Escape') return;
      event.preventDefault();
      this.close();
    });
  }

  /** @param {Annotation[]} annotations */
  set(annotations) {
    for (const mark of this.shown) this.marks.remove(mark);
    this.all = annotations;
    this.shown = annotations.map((annotation, i) => {
      const shown = document.createElement('button');
      shown.className = 'annotation';
      shown.textContent = String(i + 1);
      shown.title = annotation.title;
      shown.setAttribute('aria-label', this.nameOf(i));
      shown.addEventListener('click', () => this.open(i));
      return this.marks.add(annotation.point, shown);
    });
    if (this.opened >= annotations.length) this.close();
    this.fillList();
  }

  /** @param {number} i */
  nameOf(i) {
    return this.viewer.texts.say('annotationNamed', {number: i + 1, title: this.all[i].title});
  }

  // Lists all beside the description, for keyboards and for points that are hidden.
  fillList() {
    part('annotation-list').replaceChildren(...this.all.map((annotation, i) => {
      const entry = document.createElement('li');
      const link = document.createElement('button');
      link.textContent = annotation.title || this.viewer.texts.say('annotation', {number: i + 1});
      link.addEventListener('click', () => this.open(i));
      entry.append(link);
      return entry;
    }));
  }

  // Flies to an annotation and shows its text; before the first comes the last.
  /** @param {number} number */
  open(number) {
    const count = this.all.length;
    if (count === 0) return;
    const wasOpen = this.opened >= 0;
    this.opening();
    this.opened = (number + count) % count;
    const annotation = this.all[this.opened];
    part('annotation-title').textContent = annotation.title;
    part('annotation-text').textContent = annotation.text;
    const place = this.viewer.texts.say('placeOf', {number: this.opened + 1, count});
    part('annotation-place').textContent = place;
    part('annotation').hidden = false;
    if (!wasOpen) button('annotation-close').focus();
    flyToAnnotation(this.viewer.navigation, annotation);
    this.shown.forEach(({element}, i) => element.setAttribute('aria-expanded', String(i === this.opened)));
  }

  close() {
    if (this.opened < 0) return;
    const mark = this.shown[this.opened];
    const hadFocus = part('annotation').contains(document.activeElement);
    this.opened = -1;
    part('annotation').hidden = true;
    for (const {element} of this.shown) element.setAttribute('aria-expanded', 'false');
    if (hadFocus) (mark && !mark.hidden ? mark.element : this.viewer.canvas).focus();
  }
}
