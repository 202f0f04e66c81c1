// SPDX-License-Identifier: GPL-3.0-or-later
// Checks of <lumatlas-viewer vr> in a headset, which iwer emulates.
import assert from 'node:assert/strict';
import {readFileSync} from 'node:fs';
import {createRequire} from 'node:module';

export async function checkVr(page) {
  await page.addStyleTag({content: '#model { width: 240px; height: 180px }'});
  await page.evaluate(async () => {
    const model = document.getElementById('model');
    if (model.views.length === 0) await new Promise((resolve) => model.addEventListener('load', resolve, {once: true}));
    model.setAttribute('vr', '');
    await new Promise((resolve) => setTimeout(resolve, 300));
    window.before = model.shadowRoot.getElementById('vr').hidden;
  });
  await page.evaluate(readFileSync(createRequire(import.meta.url).resolve('iwer/build/iwer.js'), 'utf8'));
  const seen = await page.evaluate(async () => {
    const device = new window.IWER.XRDevice(window.IWER.metaQuest3, {stereoEnabled: true, ipd: 0.064});
    device.installRuntime({forceInstall: true});
    const model = document.getElementById('model');
    const button = model.shadowRoot.getElementById('vr');
    const {headset, viewer} = model._shown;
    const told = [];
    model.addEventListener('vr', ({detail}) => told.push(detail.shows));
    model.removeAttribute('vr');
    model.setAttribute('vr', '');
    const until = async (happened) => {
      for (let i = 0; i < 600 && !happened(); ++i) await new Promise((resolve) => setTimeout(resolve, 100));
    };
    await until(() => !button.hidden);
    const offered = [button.hidden, button.textContent, button.title];
    button.click();
    const apart = await new Promise((resolve) => {
      headset.drawn = () => {
        headset.drawn = () => {};
        const {gl} = viewer;
        const [width, height] = [gl.drawingBufferWidth / 2, gl.drawingBufferHeight];
        const [left, right] = [0, 1].map((eye) => {
          const pixels = new Uint8Array(4 * width * height);
          gl.readPixels(eye * width, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
          return pixels;
        });
        resolve(left.reduce((sum, value, i) => sum + Math.abs(value - right[i]), 0) / left.length);
      };
    });
    const pressed = button.getAttribute('aria-pressed');
    model.exitVr();
    await until(() => told.length === 2);
    await model.screenshot();
    return {before: window.before, offered, apart, pressed, told, after: button.getAttribute('aria-pressed')};
  });
  assert.ok(seen.apart > 1, JSON.stringify(seen));
  assert.deepEqual({...seen, apart: 0}, {
    before: true, offered: [false, 'VR', 'Show the scene in the headset'], apart: 0, pressed: 'true', told: [true, false],
    after: 'false',
  });
}
