// SPDX-License-Identifier: GPL-3.0-or-later
// Checks of the controls that fade while the visitor only looks.
import assert from 'node:assert/strict';
import {complete} from './drift_checks.mjs';

const untilShown = (page, opacity, ...names) => page.waitForFunction(
    (wanted, all) => all.every((name) => getComputedStyle(document.querySelector(name)).opacity === wanted),
    {timeout: 20000}, String(opacity), names.length > 0 ? names : ['nav', '#thumbnails']);

// Each button of the bar has a name and is pressed by the key that it names, unless a text is being written. The tools
// are open.
async function checkKeys(page) {
  const names = await page.$$eval('nav button', (all) => all.map((each) => each.textContent.trim()));
  assert.ok(names.length === 9 && names.every(Boolean), names.join());
  const keys = await page.$$eval('[aria-keyshortcuts]', (all) => all.map((each) => [
    each.getAttribute('aria-keyshortcuts'), getComputedStyle(each.querySelector('.name'), '::after').content,
  ]));
  assert.ok(keys.length === 5 && keys.every(([key, shown]) => shown.startsWith(`"${key}"`)), JSON.stringify(keys));
  const seen = (selector) => page.$eval(selector, (element) => element.checkVisibility());
  const before = [await seen('#thumbnails'), await seen('#tools')];
  await page.keyboard.press('p');
  await page.keyboard.press('t');
  assert.deepEqual([await seen('#thumbnails'), await seen('#tools')], before.map((shown) => !shown));
  await page.keyboard.press('p');
  await page.keyboard.press('t');
  assert.deepEqual([await seen('#thumbnails'), await seen('#tools')], before);
  await page.click('#edit');
  await page.type('#edit-title', 'pt');
  assert.equal(await seen('#thumbnails'), true);
  await page.click('#editing .close');
}

export async function checkQuiet(page, picture) {
  await complete(page);
  await page.evaluate(() => {
    window.lumatlasTools.quiet.idleMs = 300;
  });
  await page.mouse.move(100, 200);
  await untilShown(page, 0);
  await picture();
  assert.equal(await page.$eval('nav', (nav) => getComputedStyle(nav).pointerEvents), 'none');
  await page.evaluate(() => {
    window.lumatlasTools.quiet.idleMs = 1500;
  });
  await page.mouse.move(120, 200);
  await untilShown(page, 1);
  await page.click('#more');  // what is open keeps them
  await new Promise((resolve) => setTimeout(resolve, 3000));
  await untilShown(page, 1);
  await page.keyboard.press('h');
  await page.evaluate(() => document.activeElement.blur());
  await untilShown(page, 0);
  await page.mouse.move(100, 220);  // the key holds them hidden
  await new Promise((resolve) => setTimeout(resolve, 600));
  await untilShown(page, 0);
  await page.keyboard.press('h');
  await untilShown(page, 1);
  await checkKeys(page);
  await page.focus('#help');
  await page.keyboard.press('h');
  await untilShown(page, 0, '#thumbnails');
  await untilShown(page, 1, 'nav');  // a control in focus is seen
}
