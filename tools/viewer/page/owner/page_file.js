// SPDX-License-Identifier: GPL-3.0-or-later
// The owner's file beside a model, page.json: what its page says and shows besides the model. Printing and parsing undo
// each other.
import {length, rotationOf} from '../camera.js';
import {TextError} from '../texts/texts.js';
/**
 * @import {
 *   Annotation, CropBox, HiddenBall, LengthUnit, PageFile, Said, SaidKey, SaidValues, SavedView, Vector
 * } from '../types.d.ts'
 */

const LONGEST_TITLE = 200;
const LONGEST_TEXT = 5000;
const MOST_ENTRIES = 200;   // annotations, or hidden parts
const FARTHEST_POINT = 1e9;  // scene units
export const PAGE_FILE_NAME = 'page.json';

export class PageFileError extends TextError {
  /** @param {Said} complaint */
  constructor(complaint) {
    super('pageFileWrong', {file: PAGE_FILE_NAME, complaint});
  }
}

/** @returns {PageFile} */
export const emptyPageFile = () => ({
  title: '', description: '', view: null, up: null, unit: null, crop: null, hidden: [], annotations: [],
});

// A value of the file, and where it stands there.
class Place {
  /** @param {unknown} value @param {string} name */
  constructor(value, name) {
    this.value = value;
    this.name = name;
  }

  /** @returns {string | Said} */
  get shownName() {
    return this.name || {key: 'itself'};
  }

  /** @param {SaidKey} rule @param {SaidValues} [values] @returns {never} */
  refuse(rule, values) {
    throw new PageFileError({key: 'mustBe', values: {place: this.shownName, rule: {key: rule, values}}});
  }

  // The fields of an object, which has no others. A field that is absent is null.
  /** @param {string[]} names @returns {Record<string, Place | null>} */
  fields(...names) {
    const {value} = this;
    if (typeof value !== 'object' || value === null || Array.isArray(value)) this.refuse('ruleObject');
    const object = /** @type {Record<string, unknown>} */ (value);
    const other = Object.keys(object).find((key) => !names.includes(key));
    const values = {place: this.shownName, field: other ?? ''};
    if (other !== undefined) throw new PageFileError({key: 'unknownField', values});
    return Object.fromEntries(names.map((key) => {
      const name = this.name ? `${this.name}.${key}` : key;
      return [key, object[key] === undefined ? null : new Place(object[key], name)];
    }));
  }

  /** @param {Record<string, Place | null>} fields @param {string} key @returns {Place} */
  needed(fields, key) {
    return fields[key] ?? new Place(undefined, this.name ? `${this.name}.${key}` : key);
  }

  /** @param {number} longest */
  text(longest) {
    const {value} = this;
    if (typeof value !== 'string' || value.length > longest) this.refuse('ruleText', {count: longest});
    return /** @type {string} */ (value);
  }

  /** @param {number} least @param {number} most */
  number(least, most) {
    const {value} = this;
    if (typeof value !== 'number' || !(value >= least && value <= most)) {
      this.refuse('ruleNumber', {least, most});
    }
    return /** @type {number} */ (value);
  }

  /** @param {number} count @returns {Vector} */
  numbers(count, least = -FARTHEST_POINT) {
    const {value} = this;
    const isGood = Array.isArray(value) && value.length === count && value.every(
        (each) => typeof each === 'number' && each >= least && each <= FARTHEST_POINT);
    if (!isGood) this.refuse('ruleNumbers', {count, least, most: FARTHEST_POINT});
    return /** @type {Vector} */ (value);
  }

  // Numbers that are not all zero, whose length is then one.
  /** @param {number} count */
  direction(count) {
    const numbers = this.numbers(count);
    const size = Math.hypot(...numbers);
    if (!(size > 1e-6)) this.refuse('ruleLength');
    return numbers.map((each) => each / size);
  }

  /** @returns {Place[]} */
  list() {
    const {value} = this;
    if (!Array.isArray(value) || value.length > MOST_ENTRIES) this.refuse('ruleList', {count: MOST_ENTRIES});
    return /** @type {unknown[]} */ (value).map((each, i) => new Place(each, `${this.name}[${i}]`));
  }
}

/** @param {Place} place @returns {SavedView} */
function viewIn(place) {
  const fields = place.fields('position', 'turned', 'fov');
  return {
    position: place.needed(fields, 'position').numbers(3), turned: place.needed(fields, 'turned').direction(4),
    fov: place.needed(fields, 'fov').number(1, 169),
  };
}

/** @param {Place} place @returns {LengthUnit} */
function unitIn(place) {
  const fields = place.fields('name', 'length');
  return {name: place.needed(fields, 'name').text(20), length: place.needed(fields, 'length').number(1e-9, 1e9)};
}

/** @param {Place} place @returns {CropBox} */
function cropIn(place) {
  const fields = place.fields('center', 'size', 'turned');
  return {
    center: place.needed(fields, 'center').numbers(3), size: place.needed(fields, 'size').numbers(3, 0),
    turned: fields.turned?.direction(4) ?? [0, 0, 0, 1],
  };
}

/** @param {Place} place @returns {HiddenBall} */
function ballIn(place) {
  const fields = place.fields('center', 'radius');
  return {
    center: place.needed(fields, 'center').numbers(3),
    radius: place.needed(fields, 'radius').number(0, FARTHEST_POINT),
  };
}

/** @param {Place} place @returns {Annotation} */
function annotationIn(place) {
  const fields = place.fields('point', 'title', 'text', 'view');
  return {
    point: place.needed(fields, 'point').numbers(3), title: fields.title?.text(LONGEST_TITLE) ?? '',
    text: fields.text?.text(LONGEST_TEXT) ?? '', view: fields.view && viewIn(fields.view),
  };
}

// Throws PageFileError, one sentence that names the place.
/** @param {string} text @returns {PageFile} */
export function parsePageFile(text) {
  let value;
  try {
    value = JSON.parse(text);
  } catch {
    throw new PageFileError({key: 'notJson'});
  }
  const {title, description, view, up, unit, crop, hidden, annotations} = new Place(value, '').fields(
      'title', 'description', 'view', 'up', 'unit', 'crop', 'hidden', 'annotations');
  return {
    title: title?.text(LONGEST_TITLE) ?? '', description: description?.text(LONGEST_TEXT) ?? '',
    view: view && viewIn(view), up: up && up.direction(3), unit: unit && unitIn(unit), crop: crop && cropIn(crop),
    hidden: hidden?.list().map(ballIn) ?? [], annotations: annotations?.list().map(annotationIn) ?? [],
  };
}

// Returns the text of the file, without fields that are empty.
/** @param {PageFile} file */
export function printPageFile(file) {
  const isThere = (/** @type {unknown} */ value) =>
      value !== null && value !== '' && !(Array.isArray(value) && value.length === 0);
  const kept = (/** @type {object} */ object) => Object.fromEntries(
      Object.entries(object).filter(([, value]) => isThere(value)));
  return JSON.stringify(kept({...file, annotations: file.annotations.map(kept)}), null, 1) + '\n';
}

// Returns a function that says whether a point of the surface is shown; null: all are.
/** @param {PageFile} file */
export function shownPart({crop, hidden}) {
  if (!crop && hidden.length === 0) return null;
  const axes = crop && rotationOf(crop.turned);
  return (/** @type {number} */ x, /** @type {number} */ y, /** @type {number} */ z) => {
    if (crop && axes) {
      const [dx, dy, dz] = [x - crop.center[0], y - crop.center[1], z - crop.center[2]];
      for (let axis = 0; axis < 3; ++axis) {
        const along = axes[3 * axis] * dx + axes[3 * axis + 1] * dy + axes[3 * axis + 2] * dz;
        if (Math.abs(along) > crop.size[axis] / 2) return false;
      }
    }
    return hidden.every(({center, radius}) => length([x - center[0], y - center[1], z - center[2]]) > radius);
  };
}
