// SPDX-License-Identifier: GPL-3.0-or-later
// A random flight of FLIGHT_SECONDS (20) within FLIGHT_MIB (12) of the GPU's memory.
import assert from 'node:assert/strict';
import {complete} from './drift_checks.mjs';

export const FLIGHT_MIB = Number(process.env.FLIGHT_MIB ?? 12);
const SECONDS = Number(process.env.FLIGHT_SECONDS ?? 20);
const SEED = 7;
const LOADED_MS = 300000;           // a large site takes software long
const MOST_HEAP_GROWTH = 32 << 20;  // bytes of JavaScript's heap, from the first quarter to the end
const MOST_OBJECT_GROWTH = 1.2;     // of WebGL's objects, from the first quarter to the end

// Runs in the page: flies on at random with each frame, and changes what is shown now and then.
function fly(seed) {
  const viewer = window.lumatlas;
  const {navigation, scene, canvas} = viewer;
  let state = seed;
  const random = () => {
    state = Math.imul(state ^ (state >>> 15), 0x2c1b3c6d) + 0x9e3779b9 | 0;
    return ((state ^ (state >>> 13)) >>> 0) / 2 ** 32;
  };
  const between = (low, high) => low + (high - low) * random();
  const modes = ['picture', 'picture', 'picture', 'winner', 'coverage', 'colours'];
  const slots = scene.views.flatMap((view, slot) => view ? [slot] : []);
  window.flight = {frames: 0, most: 0, pictures: 0};
  navigation.hold.on = false;
  const step = () => {
    requestAnimationFrame(step);
    const {flight} = window;
    ++flight.frames;
    flight.most = Math.max(flight.most, viewer.renderer.bytes());
    if (viewer.shown.pictures) ++flight.pictures;
    if (random() < 0.02) {
      const place = navigation.poseOfView(slots[Math.floor(random() * slots.length)], canvas.width, canvas.height);
      navigation.goTo(place.pose, place.fov, random() < 0.5 ? performance.now() : undefined);
    } else if (random() < 0.01) {
      viewer.setMode(modes[Math.floor(random() * modes.length)]);
    } else if (random() < 0.01) {
      canvas.parentElement.style.right = `${Math.floor(between(0, 200))}px`;
    } else if (!navigation.jump) {
      navigation.turn(between(-0.1, 0.1), between(-0.05, 0.05), random() < 0.5);
      navigation.move(between(-0.1, 0.1), between(-0.05, 0.05), between(-0.1, 0.15));
    }
    viewer.moved();
  };
  step();
}

// Objects and bytes now. Garbage is collected first.
async function measured(page) {
  const client = await page.createCDPSession();
  await client.send('HeapProfiler.collectGarbage');
  await client.detach();
  const {JSHeapUsedSize: heap} = await page.metrics();
  const seen = await page.evaluate(() => {
    const {gl, memory, renderer, residents} = window.lumatlas;
    return {objects: gl.objects, most: renderer.mostBytes, allowed: memory << 20, room: residents.progress().total,
            ...window.flight};
  });
  return {heap, ...seen};
}

const sleep = (seconds) => new Promise((resolve) => setTimeout(resolve, 1000 * seconds));

export async function checkFlight(page, picture) {
  await complete(page, LOADED_MS);
  await page.evaluate(fly, SEED);
  await sleep(SECONDS / 4);
  const first = await measured(page);
  await sleep(SECONDS * 3 / 4);
  const last = await measured(page);
  await picture();
  const mebibytes = (bytes) => (bytes / 2 ** 20).toFixed(1);
  console.log(`flight: ${last.frames} frames in ${SECONDS} s, ${last.pictures} of them of photographs, of which ${last.room} ` +
      `have room; GPU at most ${mebibytes(last.most)} of ${mebibytes(last.allowed)} MiB; heap ${mebibytes(first.heap)} to ` +
      `${mebibytes(last.heap)} MiB; ${first.objects} to ${last.objects} objects of WebGL`);
  assert.ok(last.frames > first.frames && last.pictures > 0, JSON.stringify(last));
  assert.ok(last.most <= last.allowed, JSON.stringify(last));
  assert.ok(last.heap - first.heap < MOST_HEAP_GROWTH, JSON.stringify([first, last]));
  assert.ok(last.objects < MOST_OBJECT_GROWTH * first.objects, JSON.stringify([first, last]));
}
