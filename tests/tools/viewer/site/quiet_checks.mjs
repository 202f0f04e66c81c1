// SPDX-License-Identifier: GPL-3.0-or-later
// Checks of the controls that fade while the visitor only looks.
import assert from 'node:assert/strict';
import {complete} from './drift_checks.mjs';

const untilShown = (page, opacity, ...names) => page.waitForFunction(
    (wanted, all) => all.every((name) => getComputedStyle(document.querySelector(name)).opacity === wanted),
    {timeout: 20000}, String(opacity), names.length > 0 ? names : ['nav', '#thumbnails']);

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
  await page.focus('#help');
  await page.keyboard.press('h');
  await untilShown(page, 0, '#thumbnails');
  await untilShown(page, 1, 'nav');  // a control in focus is seen
}
