// SPDX-License-Identifier: GPL-3.0-or-later
// usage: node check.mjs CHROMIUM SOURCES FOLDER [PICTURES] [CHECK...]
//
// Tries the page of the site FOLDER/site in a browser. SOURCES is the folder of the page's sources. Exit 1: a check fails.
import assert from 'node:assert/strict';
import {join} from 'node:path';
import puppeteer from 'puppeteer-core';
import {opened, served, started} from './browser.mjs';
import {checkDrift, checkRest, checkSlow, withHiddenTab, withLoss, withReducedMotion} from './drift_checks.mjs';
import {FLIGHT_MIB, checkFlight} from './flight_checks.mjs';
import {checkDragging, withLargeWindow} from './dragging_checks.mjs';
import {startedFirefox} from './firefox.mjs';
import {checkHeadset, withHeadset} from './headset_checks.mjs';
import {checkLoading, withSlowNetwork} from './loading_checks.mjs';
import {onLeastDevice, withLeastDevice} from './least_device.mjs';
import {checkQuiet} from './quiet_checks.mjs';
import {checkPicture} from './picture_checks.mjs';
import {checkFrench, checkGerman, checkGermanLoss, checkTables, withFrenchVisitor} from './texts_checks.mjs';

const [chromium, sources, folder, pictures, ...wanted] = process.argv.slice(2);
const server = await served({'/': join(folder, 'site')});

// The emulator does not know that a context may be lost.
const OF_LOST_GPU = /CONTEXT_LOST_WEBGL|onDeviceFrame/;

// The driver says how it reads pixels; that is no fault of the page.
const isOfDriver = (problem) => problem.includes('GPU stall due to ReadPixels');

// Each check: what it does with the page, what is prepared before, the query, and problems that are expected.
const checks = {
  picture: {check: checkPicture('Chromium'), query: '?drift=off'},
  'picture-plain': {check: checkPicture('Chromium', 'plain'), query: '?drift=off&texels=rgb8'},
  'least-device': {
    check: onLeastDevice(checkPicture('the smallest device', 'plain')), prepare: withLeastDevice, query: '?drift=off',
  },
  headset: {check: checkHeadset, prepare: withHeadset, query: '?drift=off', expected: OF_LOST_GPU},
  drift: {check: checkDrift},
  'drift-slow': {check: checkSlow},
  'drift-off': {check: checkRest, query: '?drift=off'},
  'drift-link': {check: checkRest, query: '#at=0.1,0.1,0.3&turned=0.5,0.5,-0.5,0.5&fov=50'},
  'drift-motion': {check: checkRest, prepare: withReducedMotion},
  'drift-hidden': {check: checkRest, prepare: withHiddenTab},
  loading: {check: checkLoading, prepare: withSlowNetwork, query: '?drift=off'},
  quiet: {check: checkQuiet, query: '?drift=off'},
  dragging: {check: checkDragging, prepare: withLargeWindow, query: '?drift=off'},
  flight: {check: checkFlight, query: `?drift=off&memory=${FLIGHT_MIB}`},
  'texts-de': {check: checkGerman, query: '?drift=off&lang=de'},
  'texts-loss': {check: checkGermanLoss, prepare: withLoss, query: '?drift=off&lang=de', expected: /ERR_FAILED/},
  'texts-fr': {check: checkFrench, prepare: withFrenchVisitor, query: '?drift=off'},
  'drift-loss': {check: checkRest, prepare: withLoss, expected: /ERR_FAILED/},
};

// The same in Firefox.
const inFirefox = {'picture-firefox': {check: checkPicture('Firefox'), query: '?drift=off'}};

const isWanted = (name) => wanted.length === 0 || wanted.includes(name);

async function tryAll(browser, all) {
  for (const [name, how] of Object.entries(all)) if (isWanted(name)) await tryPage(browser, name, how);
}

async function tryPage(browser, name, {check, prepare = async () => {}, query = '', expected = /^$/}) {
  const began = performance.now();
  const problems = [];
  const page = await opened(browser, 'about:blank', problems);
  const picture = async (part = '') => {
    if (pictures) await page.screenshot({path: join(pictures, `${name}${part}.png`)});
  };
  try {
    await prepare(page);
    await page.goto(`${server.address}/index.html${query}`);
    await check(page, picture);
  } catch (error) {
    console.error(`${name}: ${problems.join('\n')}`);
    await picture('-failed');
    throw error;
  }
  await page.close();
  assert.deepEqual(problems.filter((problem) => !isOfDriver(problem) && !expected.test(problem)), []);
  console.log(`${name}: as it should be, ${((performance.now() - began) / 1000).toFixed(1)} s`);
}

checkTables(join(sources, 'page'), join(sources, 'package'));
const browser = await started(puppeteer, chromium);
try {
  await tryAll(browser, checks);
  const firefox = Object.keys(inFirefox).some(isWanted) ? await startedFirefox(puppeteer) : null;
  if (firefox) await tryAll(firefox.browser, inFirefox).finally(firefox.close);
} finally {
  await browser.close();
  server.close();
}
