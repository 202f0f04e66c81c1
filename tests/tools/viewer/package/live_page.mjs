// SPDX-License-Identifier: GPL-3.0-or-later
// usage: node live_page.mjs CHROMIUM ADDRESS PICTURES SECONDS...
//
// Opens the page of a live model, prints "ready", and begins to count seconds at a line of its input. Writes pictures of
// the page at SECONDS into the folder PICTURES, and prints, once they are there, a line of JSON for each photograph that
// the page has drawn with: its name, and when it first did, in milliseconds since 1970.
import {createInterface} from 'node:readline';
import {join} from 'node:path';
import puppeteer from 'puppeteer-core';
import {opened, started} from './browser.mjs';

const [chromium, address, pictures, ...seconds] = process.argv.slice(2);
const [WIDTH, HEIGHT] = [960, 600];

const sleep = (ms) => new Promise((resolve) => setTimeout(resolve, ms));

// Runs in the page: notes when the first picture with each photograph is drawn.
function watch() {
  window.photographs = {};
  const look = () => {
    const viewer = window.lumatlas;
    if (viewer?.renders?.photographs) {
      for (const slot of viewer.residents.current()) window.photographs[viewer.scene.views[slot].name] ??= Date.now();
    }
    requestAnimationFrame(look);
  };
  look();
}

const browser = await started(puppeteer, chromium);
const problems = [];
const page = await opened(browser, address, problems);
await page.setViewport({width: WIDTH, height: HEIGHT});
await page.evaluate(watch);
console.log('ready');
await new Promise((resolve) => createInterface({input: process.stdin}).once('line', resolve));
const began = Date.now();
for (const second of seconds) {
  await sleep(Math.max(0, began + 1000 * second - Date.now()));
  await page.screenshot({path: join(pictures, `${second}-s.jpg`), quality: 90});
}
for (const [name, ms] of Object.entries(await page.evaluate(() => window.photographs))) {
  console.log(JSON.stringify({name, ms}));
}
for (const problem of problems) console.error(problem);
await browser.close();
process.exit();
