// SPDX-License-Identifier: GPL-3.0-or-later
// Says what the page has to say in the visitor's language, by a table for each language.
import {DE} from './de.js';
import {EN} from './en.js';
import {FR} from './fr.js';
/** @import {Said, SaidValues, TextKey, SaidKey} from '../types.d.ts' */

// Each language with its table, and the locale by whose rules names are listed.
/** @type {Record<string, {table: Record<TextKey, string>, locale: string}>} */
export const LANGUAGES = {
  en: {table: EN, locale: 'en-GB'},
  de: {table: DE, locale: 'de'},
  fr: {table: FR, locale: 'fr'},
};

// Returns the first language that there is a table for; English, if there is none. `wanted`: language tags, best first.
/** @param {readonly (string | null | undefined)[]} wanted */
export function languageOf(wanted) {
  const tags = wanted.map((tag) => (tag ?? '').toLowerCase().split(/[-_]/)[0]);
  return tags.find((tag) => Object.hasOwn(LANGUAGES, tag)) ?? 'en';
}

export class Texts {
  // `language`: a key of LANGUAGES.
  /** @param {string} language */
  constructor(language) {
    const {table, locale} = LANGUAGES[language];
    this.language = language;
    this.table = table;
    this.plurals = new Intl.PluralRules(locale);
    this.lists = new Intl.ListFormat(locale);
  }

  // Returns a text with its values, of which `count` chooses between one and other.
  /** @param {SaidKey} key @param {SaidValues} [values] @returns {string} */
  say(key, values = {}) {
    const {table} = this;
    const form = Object.hasOwn(table, key) ? key :
      `${key}.${this.plurals.select(Number(values.count)) === 'one' ? 'one' : 'other'}`;
    return table[/** @type {TextKey} */ (form)].replace(/\{(\w+)\}/g, (_, name) => this.printed(values[name]));
  }

  /** @param {string | number | Said} value */
  printed(value) {
    return typeof value === 'object' ? this.say(value.key, value.values) : String(value);
  }

  // Returns what an error says; that of a browser or of a reader of files is in its own words.
  /** @param {unknown} error */
  of(error) {
    if (error instanceof TextError) return this.printed(error.said);
    return error instanceof Error ? error.message : String(error);
  }

  /** @param {string[]} names */
  list(names) {
    return this.lists.format(names);
  }
}

export const ENGLISH = new Texts('en');

// An error whose sentence is in the tables. Its message is the English one.
export class TextError extends Error {
  /** @param {SaidKey} key @param {SaidValues} [values] */
  constructor(key, values = {}) {
    super(ENGLISH.say(key, values));
    /** @type {Said} */
    this.said = {key, values};
  }
}

// Returns what an error says, as a value of another text.
/** @param {unknown} error @returns {string | Said} */
export const saidOf = (error) => error instanceof TextError ? error.said : ENGLISH.of(error);
