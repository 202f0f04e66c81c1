// SPDX-License-Identifier: GPL-3.0-or-later
// usage: node check.mjs CHROMIUM FOLDER [PICTURES]
//
// Tries the examples of the npm package in a browser. FOLDER has page/, into which the package is installed, and the
// models model/, model.glb and site/. Exit 1: a check fails.
import assert from 'node:assert/strict';
import {join} from 'node:path';
import puppeteer from 'puppeteer-core';
import {opened, served, started} from './browser.mjs';
import {checkElement, checkNetwork} from './element_checks.mjs';
import {checkEnd, checkThree} from './three_checks.mjs';
import {checkVr} from './vr_checks.mjs';

const [chromium, folder, pictures] = process.argv.slice(2);
const models = {'/model/': join(folder, 'model'), '/others/': folder};
const server = await served({'/': join(folder, 'page'), ...models});
const strict = await served(models);
const open = await served(models, {'Access-Control-Allow-Origin': '*'});
const browser = await started(puppeteer, chromium);

// The driver says how it reads pixels; that is no fault of the page.
const isOfDriver = (problem) => problem.includes('GPU stall due to ReadPixels');

// Models without an owner's file, of which the browser tells.
const isOfOwner = (problem) => /404.*page\.json/.test(problem);

// Opens an example and calls `check(page)`. The page must have no problem except those that `expected` matches.
async function example(name, check, {end = async () => {}, expected = /^$/} = {}) {
  const began = performance.now();
  const problems = [];
  const page = await opened(browser, `${server.address}/examples/${name}/index.html`, problems);
  try {
    await check(page);
  } catch (error) {
    console.error(`${name}: ${problems.join('\n')}`);
    if (pictures) await page.screenshot({path: join(pictures, `${name}.png`)});
    throw error;
  }
  if (pictures) await page.screenshot({path: join(pictures, `${name}.png`)});
  await end(page);
  await page.close();
  assert.deepEqual(problems.filter(
      (problem) => !isOfDriver(problem) && !isOfOwner(problem) && !expected.test(problem)), []);
  console.log(`${name}: as it should be, ${((performance.now() - began) / 1000).toFixed(1)} s`);
}

async function checkBundler(page) {
  await page.waitForFunction(() => document.querySelectorAll('button').length === 6, {timeout: 60000});
  await page.evaluate(() => document.querySelectorAll('button')[2].click());
  await page.evaluate(() => document.querySelectorAll('button')[5].click());
  await page.waitForFunction(() => document.querySelector('main > img')?.complete, {timeout: 60000});
}

try {
  await example('html', checkElement);
  await example('bundler', checkBundler);
  const others = {strict: strict.address, open: open.address};
  await example('html', (page) => checkNetwork(page, others), {expected: /404|CORS|ERR_FAILED|AbortError|was taken away/});
  await example('html', checkVr);
  await example('three', checkThree, {end: checkEnd, expected: /not stretched/});
} finally {
  await browser.close();
  for (const {close} of [server, strict, open]) close();
}
