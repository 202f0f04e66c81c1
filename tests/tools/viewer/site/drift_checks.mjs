// SPDX-License-Identifier: GPL-3.0-or-later
// Checks of the slow drift with which the page opens.
import assert from 'node:assert/strict';

export const complete = (page, timeout = 60000) => page.waitForFunction(
    () => document.documentElement.dataset.state === 'complete', {timeout});
export const sharp = (page) => page.waitForFunction(() => window.lumatlas.still === 'done', {timeout: 90000});
const sleep = (ms) => new Promise((resolve) => setTimeout(resolve, ms));
const stateOf = (page) => page.evaluate(() => window.lumatlasTools.drift?.state ?? 'none');

// Lets the drift go on although software draws slowly, and notes the camera of each frame.
function watch() {
  const {drift} = window.lumatlasTools;
  const {navigation} = window.lumatlas;
  const {hold} = navigation;
  drift.leastPixels = 0;
  window.frames = [];
  const {step} = drift;
  drift.step = (seconds) => {
    const before = navigation.pose;
    step.call(drift, seconds);
    window.frames.push({
      seconds, far: hold.distance(before, navigation.pose), share: hold.share, enough: hold.enough(),
    });
  };
}

// It moves smoothly where the picture was photographed, and a touch ends it; the still frame is then drawn sharp.
export async function checkDrift(page, picture) {
  await complete(page);
  const first = await page.evaluate(watch);
  assert.equal(first, undefined);
  await page.waitForFunction(() => window.lumatlasTools.drift.state === 'drifts', {timeout: 90000});
  const start = await page.evaluate(() => window.lumatlas.navigation.pose);
  await page.waitForFunction(() => window.lumatlasTools.drift.legs >= 3, {timeout: 90000});
  await picture();
  await page.mouse.move(200, 200);
  assert.equal(await stateOf(page), 'drifts');  // a mouse that only passes by is no touch
  await page.mouse.down();
  await page.mouse.up();
  assert.equal(await stateOf(page), 'ended');
  const seen = await page.evaluate((from) => {
    const {navigation} = window.lumatlas;
    const speeds = window.frames.map(({far, seconds}) => far / Math.max(seconds, 1e-3));
    const changes = speeds.slice(1).map((speed, i) => Math.abs(speed - speeds[i]));
    return {
      frames: window.frames.length, fastest: Math.max(...speeds), change: Math.max(...changes),
      least: Math.min(...window.frames.map(({share, enough}) => share / enough)), hash: location.hash,
      away: navigation.hold.distance(from, navigation.pose),
    };
  }, start);
  console.log(`drift: ${seen.frames} frames, fastest ${seen.fastest.toFixed(3)} depths and radians a second, at least ` +
      `${seen.least.toFixed(2)} times enough photographed`);
  assert.ok(seen.away > 0.02, JSON.stringify(seen));
  assert.ok(seen.fastest < 0.25, JSON.stringify(seen));
  assert.ok(seen.change < 0.1, JSON.stringify(seen));
  assert.ok(seen.least > 1, JSON.stringify(seen));
  const ended = await page.evaluate(() => window.lumatlas.navigation.pose);
  await sharp(page);
  const rests = await page.evaluate(() => ({pose: window.lumatlas.navigation.pose, size: window.lumatlas.stillSize}));
  assert.deepEqual(rests.pose, ended);
  assert.ok(rests.size[0] >= 500, `a still frame ${rests.size[0]} pixels wide`);
}

// A key ends it too. Where the GPU is slow, it ends by itself, and the picture becomes sharp.
export async function checkSlow(page) {
  await complete(page);
  await page.waitForFunction(() => window.lumatlasTools.drift.state === 'ended', {timeout: 90000});
  await sharp(page);
}

// It does not begin: there is none, or what it needs is not there.
export async function checkRest(page) {
  await complete(page);
  await page.evaluate(() => {
    if (window.lumatlasTools.drift) window.lumatlasTools.drift.leastPixels = 0;
  });
  await sharp(page);
  await sleep(3000);
  const state = await stateOf(page);
  assert.ok(['none', 'waits'].includes(state), state);
}

export const withReducedMotion = (page) => page.emulateMediaFeatures([{name: 'prefers-reduced-motion', value: 'reduce'}]);

export const withHiddenTab = (page) => page.evaluateOnNewDocument(() => {
  Object.defineProperty(Document.prototype, 'visibilityState', {get: () => 'hidden'});
});

// A page that lacks a photograph.
export async function withLoss(page) {
  await page.setRequestInterception(true);
  page.on('request', (request) => {
    if (/00003-[0-9a-f]+\.jpg$/.test(request.url())) return request.abort();
    return request.continue();
  });
}
