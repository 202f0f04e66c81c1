// SPDX-License-Identifier: GPL-3.0-or-later
// Shows in an element what the owner's file says of its model: the annotations, as numbered buttons at points of the
// surface. A click flies there and opens the text.
import {Marks} from '../page/over/marks.js';
import {flyToAnnotation} from '../page/owner/owners_views.js';
/** @import {Viewer} from '../page/viewer.js' */
/** @import {Annotation} from '../page/types.d.ts' */

export const MARKS_STYLE = `
#marks { position: absolute; inset: 0; overflow: hidden; pointer-events: none; }
.mark { position: absolute; left: 0; top: 0; translate: -50% -50%; width: 26px; height: 26px; padding: 0;
  font: 600 13px/1 system-ui, sans-serif; color: #eee; background: #1b1e23d0; border: 2px solid #fff;
  border-radius: 50%; cursor: pointer; pointer-events: auto; }
.mark.behind { visibility: hidden; }
.mark[aria-expanded="true"] { background: #47a; }
.mark:focus-visible, #card button:focus-visible { outline: 2px solid #9cf; }
#card { position: absolute; inset: auto 8px 12px; max-width: 300px; max-height: 45%; overflow: auto; padding: 8px 10px;
  background: #1b1e23e6; border: 1px solid #fff3; border-radius: 6px; overflow-wrap: anywhere; white-space: pre-wrap;
  pointer-events: auto; }
#card h2 { margin: 0 24px 4px 0; font-size: 14px; }
#card p { margin: 0; }
#card button { position: absolute; top: 4px; right: 4px; width: 24px; height: 24px; padding: 0; font: inherit;
  color: inherit; background: none; border: none; cursor: pointer; }
`;

/** @param {string} tag @param {string} text */
function madeWith(tag, text) {
  const made = document.createElement(tag);
  made.textContent = text;
  return made;
}

export class OwnerMarks {
  // `layer` is the element that lies over the canvas; the marks and the text of one are put into it.
  /** @param {Viewer} viewer @param {HTMLElement} layer @param {Annotation[]} annotations */
  constructor(viewer, layer, annotations) {
    this.viewer = viewer;
    this.layer = layer;
    this.annotations = annotations;
    this.marks = new Marks(viewer, layer);
    viewer.finished = () => this.marks.look();
    this.buttons = annotations.map((annotation, i) => this.button(annotation, i));
    this.card = document.createElement('section');
    this.card.id = 'card';
    this.card.hidden = true;
    this.card.setAttribute('role', 'status');
    layer.append(this.card);
    this.opened = -1;  // number of the one whose text is open; -1: none
    layer.addEventListener('keydown', (event) => {
      if (event.key === 'Escape') this.close();
    });
  }

  /** @param {Annotation} annotation @param {number} i */
  button(annotation, i) {
    const shown = document.createElement('button');
    shown.textContent = String(i + 1);
    shown.title = annotation.title;
    const label = this.viewer.texts.say('annotationNamed', {number: i + 1, title: annotation.title});
    shown.setAttribute('aria-label', label);
    shown.setAttribute('aria-expanded', 'false');
    shown.addEventListener('click', () => this.open(i));
    this.marks.add(annotation.point, shown);
    return shown;
  }

  // Flies to an annotation and shows its text.
  /** @param {number} i */
  open(i) {
    const annotation = this.annotations[i];
    this.opened = i;
    const end = madeWith('button', '×');
    end.setAttribute('aria-label', this.viewer.texts.say('close'));
    end.addEventListener('click', () => this.close());
    this.card.replaceChildren(madeWith('h2', annotation.title), madeWith('p', annotation.text), end);
    this.card.hidden = false;
    this.tell();
    flyToAnnotation(this.viewer.navigation, annotation);
  }

  close() {
    if (this.opened < 0) return;
    const before = this.buttons[this.opened];
    this.opened = -1;
    this.card.hidden = true;
    this.tell();
    before.focus({preventScroll: true});
  }

  tell() {
    this.buttons.forEach((shown, i) => shown.setAttribute('aria-expanded', String(i === this.opened)));
  }

  // Called before each frame.
  follow() {
    this.marks.follow();
  }

  // Takes all out of the layer.
  end() {
    this.layer.replaceChildren();
  }
}
