// SPDX-License-Identifier: GPL-3.0-or-later
// Shows what the owner's file says: title, description, up axis, unit, the shown part, annotations, the first view.
import {button, part} from '../elements.js';
import {Annotations} from './annotations.js';
import {poseOfSaved} from './owners_views.js';
import {shownPart} from './page_file.js';
/** @import {Marks} from '../over/marks.js' */
/** @import {Measuring} from '../over/measuring.js' */
/** @import {Viewer} from '../viewer.js' */
/** @import {PageFile} from '../types.d.ts' */

export class OwnerPage {
  /** @param {Viewer} viewer @param {Marks} marks @param {Measuring} measuring @param {PageFile} file */
  constructor(viewer, marks, measuring, file) {
    this.viewer = viewer;
    this.measuring = measuring;
    this.unit = measuring.unit;  // of a file that says none
    this.siteTitle = document.title;
    this.annotations = new Annotations(viewer, marks);
    this.file = file;
    this.shownPart = '';  // what the renderer was told of the shown part
    this.show(file);
  }

  /** @param {PageFile} file */
  show(file) {
    this.file = file;
    document.title = file.title || this.siteTitle;
    const about = button('about');
    about.textContent = file.title || this.viewer.texts.say('about');
    about.hidden = !file.title && !file.description && file.annotations.length === 0;
    part('about-title').textContent = file.title;
    part('description').textContent = file.description;
    this.viewer.navigation.setUp(file.up);
    this.measuring.setUnit(file.unit ?? this.unit);
    this.annotations.set(file.annotations);
    this.showPart();
  }

  // Hides what the file hides.
  showPart() {
    const {crop, hidden} = this.file;
    const key = JSON.stringify([crop, hidden]);
    if (key === this.shownPart) return;
    const test = shownPart(this.file);
    if (test || this.shownPart) this.viewer.setShownPart(test, Boolean(crop));
    this.shownPart = key;
  }

  goToFirstView() {
    const {view} = this.file;
    if (view) this.viewer.navigation.set(poseOfSaved(view), view.fov);
  }

  // Flies to the owner's first view; without one, to the model's.
  flyToFirstView() {
    const {view} = this.file;
    const {navigation, scene, canvas} = this.viewer;
    const place = view ? {pose: poseOfSaved(view), fov: view.fov} :
      navigation.poseOfView(scene.first_view, canvas.width, canvas.height);
    if (place) navigation.goTo(place.pose, place.fov, performance.now());
  }
}
