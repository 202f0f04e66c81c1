// SPDX-License-Identifier: GPL-3.0-or-later
// Checks of the languages of the page. SOURCES is the folder of its scripts, from which texts/ was copied beside this.
import assert from 'node:assert/strict';
import {readFileSync, readdirSync} from 'node:fs';
import {join} from 'node:path';
import {LANGUAGES, languageOf} from './texts/texts.js';
import {complete, sharp} from './drift_checks.mjs';

const parametersOf = (text) => [...text.matchAll(/\{(\w+)\}/g)].map(([, name]) => name).sort();

function textOf(folder) {
  return readdirSync(folder, {withFileTypes: true}).map((entry) => {
    if (entry.isDirectory()) return entry.name === 'texts' ? '' : textOf(join(folder, entry.name));
    return /\.(js|html)$/.test(entry.name) ? readFileSync(join(folder, entry.name), 'utf8') : '';
  }).join('\n');
}

// Every table has every key with the same values, and every key is used.
export function checkTables(...sources) {
  const english = LANGUAGES.en.table;
  for (const [language, {table}] of Object.entries(LANGUAGES)) {
    assert.deepEqual(Object.keys(table).sort(), Object.keys(english).sort(), language);
    for (const [key, text] of Object.entries(table)) {
      assert.ok(text !== '', `${language}: ${key}`);
      assert.deepEqual(parametersOf(text), parametersOf(english[key]), `${language}: ${key}`);
      assert.equal(text.split('`').length, english[key].split('`').length, `${language}: ${key}`);
    }
  }
  const text = sources.map(textOf).join('\n');
  const unused = Object.keys(english).map((key) => key.replace(/\.(one|other)$/, '')).filter(
      (key) => !text.includes(`'${key}'`) && !text.includes(`"${key}"`));
  assert.deepEqual(unused, []);
  assert.equal(languageOf(['xx', null, 'de-AT', 'fr']), 'de');
  assert.equal(languageOf(['constructor', '']), 'en');
  console.log(`texts: ${Object.keys(LANGUAGES).length} languages with ${Object.keys(english).length} texts each`);
}

const TRANSLATED = Object.entries(LANGUAGES.en.table).filter(
    ([key, text]) => text !== LANGUAGES.de.table[key] && /[a-z]{2}/.test(text.replace(/\{\w+\}/g, '')));
const ENGLISH = TRANSLATED.map(([, text]) => new RegExp('^\\s*' + text.split(/\{\w+\}/).map(
    (part) => part.replaceAll('`', '').replace(/[.*+?^${}()|[\]\\]/g, '\\$&')).join('.*') + '\\s*$', 's'));
const WORDS = /\b(the|of|and|is|are|this|that|with|photographs?|click|save|view|camera|cannot|from)\b/i;

// All that the page shows or tells, hidden parts too: its text, and attributes that hold a text. The others name
// elements, files and states.
const shownTexts = (page) => page.evaluate(() => {
  const names = /^(id|class|for|name|type|value|href|src|style|role|data-.*|aria-(controls|labelledby|live|pressed))$/;
  const found = [];
  const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_ALL);
  for (let node = walker.currentNode; node; node = walker.nextNode()) {
    if (node.parentElement?.closest('script, style, noscript, code')) continue;
    if (node instanceof Text && node.textContent.trim()) found.push(node.textContent.trim());
    if (!(node instanceof Element)) continue;
    for (const {name, value} of node.attributes) if (!names.test(name) && value.trim()) found.push(value.trim());
  }
  return found;
});

async function assertGerman(page, where) {
  const texts = await shownTexts(page);
  assert.ok(texts.length > 60, `${where}: ${texts.length} texts`);
  const english = texts.filter((text) => ENGLISH.some((pattern) => pattern.test(text)) || WORDS.test(text));
  assert.deepEqual(english, [], where);
}

// The page in German, in all of its states: no text of it is English.
export async function checkGerman(page, picture) {
  await complete(page);
  await sharp(page);
  assert.equal(await page.evaluate(() => document.documentElement.lang), 'de');
  await assertGerman(page, 'at rest');
  await page.click('#more');
  await page.click('#edit');
  await page.evaluate(() => {
    const {editor, path, measuring, owner, comparison} = window.lumatlasTools;
    const point = window.lumatlas.navigation.pivot();
    editor.startPlacing('annotation');
    editor.place({point, deviation: null});
    editor.startPlacing('hidden');
    editor.place({point, deviation: null});
    owner.annotations.open(0);
    path.add();
    path.add();
    measuring.take({point, deviation: null});
    comparison.toggle();
  });
  await assertGerman(page, 'while editing');
  await picture();
  for (const mode of ['winner', 'weights', 'coverage', 'geometry', 'colours']) {
    await page.select('#mode', mode);
    await assertGerman(page, mode);
  }
  await page.evaluate(() => {
    const {editor, measuring, walking} = window.lumatlasTools;
    editor.tell();
    editor.startPlacing('hidden');
    measuring.take(null);
    walking.turn(true);
    document.getElementById('hold').click();
    document.getElementById('link').click();
    document.getElementById('help').click();
  });
  await assertGerman(page, 'with help');
  await page.evaluate(async () => {
    const {editor} = window.lumatlasTools;
    await editor.openFile(new Blob(['{"titel": "x"}']));
  });
  assert.match(await page.$eval('#edit-status', (line) => line.textContent), /^page\.json: es hat das unbekannte Feld/);
  await assertGerman(page, 'with a wrong file');
}

// A page that lacks a photograph says so in German, and that the GPU is gone.
export async function checkGermanLoss(page) {
  await complete(page);
  await page.waitForSelector('#losses:not([hidden])', {timeout: 30000});
  assert.match(await page.$eval('#losses', (line) => line.textContent), /^1 Foto fehlt: .* kann nicht geladen werden: /);
  await page.evaluate(() => window.lumatlas.gpuLost(true));
  assert.match(await page.$eval('#gpu', (line) => line.textContent), /^Der Browser hat die GPU weggenommen/);
}

export const withFrenchVisitor = (page) => page.evaluateOnNewDocument(() => {
  Object.defineProperty(navigator, 'languages', {get: () => ['oc', 'fr-CA', 'en']});
});

// Without a language in its address, the page takes the visitor's.
export async function checkFrench(page) {
  await complete(page);
  const seen = await page.evaluate(
      () => [document.documentElement.lang, document.getElementById('more').textContent.trim(), window.lumatlas.texts.language]);
  assert.deepEqual(seen, ['fr', 'Outils', 'fr']);
}
