// SPDX-License-Identifier: GPL-3.0-or-later
// Drags the camera by the mouse for DRAGGING_SECONDS (5), and counts the pictures that are drawn meanwhile, and the
// processor time of the browser.
import assert from 'node:assert/strict';
import {readFileSync, readdirSync} from 'node:fs';
import {complete} from './drift_checks.mjs';

const SECONDS = Number(process.env.DRAGGING_SECONDS ?? 5);
const [WIDTH, HEIGHT] = [1280, 800];
const LOADED_MS = 300000;   // a large site takes software long
const SETTLED_SECONDS = 3;  // until the pictures' size is that which the GPU draws in time
const RADIUS = 150;         // of the circle that the mouse goes along, pixels
const STEP_MS = 12;
const A_ROUND_MS = 4000;

export const withLargeWindow = (page) => page.setViewport({width: WIDTH, height: HEIGHT});

const sleep = (ms) => new Promise((resolve) => setTimeout(resolve, ms));

// Runs in the page: notes each interactive frame that the GPU has finished.
function watch() {
  const viewer = window.lumatlas;
  window.dragged = [];
  const {sizes} = viewer;
  const {adapt} = sizes;
  sizes.adapt = (ms) => {
    window.dragged.push({ms, share: sizes.share});
    adapt.call(sizes, ms);
  };
}

async function drag(page, seconds) {
  const began = performance.now();
  for (let ms = 0; ms < 1000 * seconds; ms = performance.now() - began) {
    const angle = 2 * Math.PI * ms / A_ROUND_MS;
    await page.mouse.move(WIDTH / 2 + RADIUS * Math.cos(angle), HEIGHT / 2 + RADIUS * Math.sin(angle));
    await sleep(STEP_MS);
  }
  return (performance.now() - began) / 1000;
}

// Returns the processor time that a process and its descendants have taken, in milliseconds.
function processorMs(root) {
  const TICK_MS = 10;  // of /proc
  const processes = new Map();
  for (const pid of readdirSync('/proc').filter((name) => /^\d+$/.test(name))) {
    try {
      const fields = readFileSync(`/proc/${pid}/stat`, 'utf8').replace(/^.*\) /s, '').split(' ').map(Number);
      processes.set(Number(pid), {parent: fields[1], ticks: fields[11] + fields[12]});
    } catch {
      // It has ended meanwhile.
    }
  }
  const isOfRoot = (pid) => pid === root || (processes.has(pid) && isOfRoot(processes.get(pid).parent));
  let ticks = 0;
  for (const [pid, {ticks: own}] of processes) if (isOfRoot(pid)) ticks += own;
  return TICK_MS * ticks;
}

const medianOf = (values) => [...values].sort((a, b) => a - b)[Math.floor(values.length / 2)];

export async function checkDragging(page, picture) {
  await complete(page, LOADED_MS);
  await page.evaluate(watch);
  await page.mouse.move(WIDTH / 2 + RADIUS, HEIGHT / 2);
  await page.mouse.down();
  await drag(page, SETTLED_SECONDS);
  await page.evaluate(() => window.dragged.length = 0);
  const {pid} = page.browser().process();
  const before = processorMs(pid);
  const seconds = await drag(page, SECONDS);
  const pictures = await page.evaluate(() => window.dragged);
  const msEach = (processorMs(pid) - before) / Math.max(1, pictures.length);
  await picture();
  await page.mouse.up();
  assert.ok(pictures.length > 1, `${pictures.length} pictures in ${seconds} s`);
  const shares = pictures.map(({share}) => share);
  console.log(`dragging at ${WIDTH} x ${HEIGHT}: ${(pictures.length / seconds).toFixed(1)} pictures a second, median ` +
      `${medianOf(pictures.map(({ms}) => ms)).toFixed(0)} ms at ${medianOf(shares).toFixed(2)} of the pixels along a side, ` +
      `${msEach.toFixed(0)} ms of processor time a picture`);
}
