// SPDX-License-Identifier: GPL-3.0-or-later
// The smallest check of pictures, for each browser: the model from the cameras of its photographs.
import assert from 'node:assert/strict';
import {complete, sharp} from './drift_checks.mjs';

const LEAST_PSNR_DB = 45;   // between browsers, whose GPU programs round in their own ways
const LEAST_PHOTO_DB = 20;  // between the model and the photograph

// Pictures from the cameras of three photographs, and their photographs, each RGBA.
async function pictures(page) {
  const drawn = await page.evaluate(drawPictures);
  return drawn.map(({pixels, photograph}) => ({
    pixels: Buffer.from(pixels, 'base64'), photograph: Buffer.from(photograph, 'base64'),
  }));
}

// Runs in the page. Bytes are as base64, because numbers one by one take a browser long to hand out.
async function drawPictures() {
  const viewer = window.lumatlas;
  const packed = (bytes) => btoa(Array.from(bytes, (byte) => String.fromCharCode(byte)).join(''));
  const result = [];
  for (const view of viewer.scene.views.filter((each, i) => each && i % 3 === 0)) {
    const image = new Image();
    image.src = new URL(view.photograph, document.baseURI).href;
    await image.decode();
    const canvas = document.createElement('canvas');
    [canvas.width, canvas.height] = [view.width, view.height];
    const context = canvas.getContext('2d');
    context.drawImage(image, 0, 0, view.width, view.height);
    const photograph = context.getImageData(0, 0, view.width, view.height).data;
    result.push({pixels: packed(viewer.pixels(view)), photograph: packed(photograph)});
  }
  return result;
}

// In decibels, where both have a surface.
function psnr(a, b) {
  let [sum, count] = [0, 0];
  for (let i = 0; i < a.length; i += 4) {
    if (a[i + 3] === 0 || b[i + 3] === 0) continue;
    for (let channel = 0; channel < 3; ++channel, ++count) sum += (a[i + channel] - b[i + channel]) ** 2;
  }
  assert.ok(count > a.length / 4, 'there is a surface');
  return 10 * Math.log10(255 ** 2 / Math.max(sum / count, 1e-9));
}

// The pictures of each browser, by the form that photographs have on its GPU.
const seen = {compressed: new Map(), plain: new Map()};

// Returns the check for a browser; its pictures are compared with those of the browsers before it of the same form.
export const checkPicture = (name, form = 'compressed') => async (page, picture) => {
  await complete(page);
  await sharp(page);
  await picture();
  const drawn = await pictures(page);
  assert.equal(drawn.length, 3);
  for (const {pixels, photograph} of drawn) {
    const db = psnr(pixels, photograph);
    assert.ok(db > LEAST_PHOTO_DB, `${name}: ${db} dB against the photograph`);
  }
  for (const [other, before] of seen[form]) {
    const db = drawn.map(({pixels}, i) => psnr(pixels, before[i].pixels));
    console.log(`${name} against ${other}: ${db.map((value) => value.toFixed(1)).join(', ')} dB`);
    assert.ok(Math.min(...db) > LEAST_PSNR_DB, `${name} against ${other}: ${db} dB`);
  }
  seen[form].set(name, drawn);
};
