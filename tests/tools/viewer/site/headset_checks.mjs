// SPDX-License-Identifier: GPL-3.0-or-later
// Checks of the page in a headset, which iwer emulates: the canvas is then the headset's screen, the left eye's half
// first.
import assert from 'node:assert/strict';
import {readFileSync} from 'node:fs';
import {createRequire} from 'node:module';

const IPD = 0.064;  // metres between the eyes

// Gives a page a headset with two controllers.
export async function withHeadset(page) {
  const emulator = readFileSync(createRequire(import.meta.url).resolve('iwer/build/iwer.js'), 'utf8');
  await page.evaluateOnNewDocument(`${emulator}
    window.device = new IWER.XRDevice(IWER.metaQuest3, {stereoEnabled: true, ipd: ${IPD}});
    device.installRuntime({forceInstall: true});`);
}

// Functions for the page.
function prepare() {
  const viewer = window.lumatlas;
  const {headset} = window.lumatlasTools;
  window.nextFrame = () => new Promise((resolve) => {
    headset.drawn = () => {
      headset.drawn = () => {};
      resolve();
    };
  });
  // The pictures of both eyes, RGBA from the bottom up, and the head's pose with which they were drawn.
  window.eyes = () => new Promise((resolve) => {
    headset.drawn = () => {
      headset.drawn = () => {};
      const {gl, navigation} = viewer;
      const [width, height] = [gl.drawingBufferWidth / 2, gl.drawingBufferHeight];
      const pictures = [0, 1].map((eye) => {
        const pixels = new Uint8Array(4 * width * height);
        gl.readPixels(eye * width, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
        return pixels;
      });
      resolve({pictures, width, height, pose: navigation.pose});
    };
  });
  // The picture of a camera as an ordinary interactive frame, `across` scene units right of a pose, 90 degrees high.
  window.ordinary = ({width, height, pose: {position: p, rotation: r}}, across) => {
    const {gl, renderer} = viewer;
    const center = [0, 1, 2].map((axis) => p[axis] + across * r[axis]);
    const translation = [0, 1, 2].map((i) => -(r[3 * i] * center[0] + r[3 * i + 1] * center[1] + r[3 * i + 2] * center[2]));
    const target = renderer.draw(
        {width, height, fx: height / 2, fy: height / 2, cx: width / 2, cy: height / 2, rotation: r, translation});
    const pixels = new Uint8Array(4 * width * height);
    gl.bindFramebuffer(gl.FRAMEBUFFER, target.blend);
    gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
    return pixels;
  };
  // Mean difference in levels of two pictures where there is surface.
  window.apart = (a, b) => {
    let [sum, count] = [0, 0];
    for (let i = 0; i < a.length; i += 4) {
      if (b[i + 3] === 0) continue;
      for (let channel = 0; channel < 3; ++channel, ++count) sum += Math.abs(a[i + channel] - b[i + channel]);
    }
    return sum / count;
  };
}

// Presses the button and waits for the first pictures.
async function begin(page) {
  await page.click('#headset');
  await page.waitForFunction(() => document.documentElement.dataset.headset === 'shows');
  await page.evaluate(() => window.nextFrame());
}

async function end(page) {
  await page.evaluate(() => window.lumatlasTools.headset.end());
  await page.waitForFunction(() => document.documentElement.dataset.headset === 'rests');
}

// Each eye sees the model from its own place, and the head is where the camera was.
async function checkEyes(page, picture) {
  await page.evaluate(() => window.lumatlas.setQuality('sharp'));
  const before = await page.evaluate(() => window.lumatlas.navigation.pose);
  await begin(page);
  const seen = await page.evaluate(async (ipd) => {
    const frame = await window.eyes();
    const {typicalDepth} = window.lumatlas.navigation;
    const half = ipd / 2 * typicalDepth / 2;  // 2 metres are the typical depth of a scene of unknown lengths
    const expected = [-half, half].map((across) => window.ordinary(frame, across));
    const [left, right] = frame.pictures;
    return {
      own: [window.apart(left, expected[0]), window.apart(right, expected[1])],
      other: [window.apart(left, expected[1]), window.apart(right, expected[0])],
      pose: frame.pose, canvas: [frame.width, frame.height], up: window.lumatlas.navigation.up,
    };
  }, IPD);
  await picture();
  console.log(`eyes of ${seen.canvas.join(' x ')} pixels: levels apart from their own cameras ${seen.own.map(
      (value) => value.toFixed(3)).join(', ')}, from each other's ${seen.other.map((value) => value.toFixed(3)).join(', ')}`);
  for (const eye of [0, 1]) assert.ok(seen.own[eye] < 0.3 && seen.other[eye] > 2, JSON.stringify(seen));
  const moved = Math.hypot(...before.position.map((value, axis) => value - seen.pose.position[axis]));
  assert.ok(moved < 1e-6, `the head is ${moved} away`);
  const level = [0, 1, 2].reduce((sum, axis) => sum + seen.pose.rotation[axis] * seen.up[axis], 0);
  assert.ok(Math.abs(level) < 1e-6, 'the eyes are side by side');
}

// The left stick flies where the head looks, the right one turns by 30 degrees each time that it is pushed.
async function checkSticks(page) {
  const seen = await page.evaluate(async () => {
    const {navigation} = window.lumatlas;
    const frames = async (count) => {
      for (let i = 0; i < count; ++i) await window.nextFrame();
    };
    const {left, right} = window.device.controllers;
    const start = navigation.pose;
    left.updateAxes('thumbstick', 0, -1);
    await frames(4);
    left.updateAxes('thumbstick', 0, 0);
    await frames(1);
    const flown = navigation.pose;
    right.updateAxes('thumbstick', 1, 0);
    await frames(4);
    right.updateAxes('thumbstick', 0, 0);
    await frames(2);
    const turned = navigation.pose;
    const dot = (a, b) => a.reduce((sum, value, axis) => sum + value * b[axis], 0);
    const forward = ({rotation}) => rotation.slice(6, 9);
    const way = flown.position.map((value, axis) => value - start.position[axis]);
    const right0 = start.rotation.slice(0, 3);
    return {
      far: Math.hypot(...way) / navigation.typicalDepth, ahead: dot(way, forward(start)) / Math.hypot(...way),
      angle: Math.acos(dot(forward(turned), forward(flown))) * 180 / Math.PI, side: dot(forward(turned), right0),
      stays: Math.hypot(...turned.position.map((value, axis) => value - flown.position[axis])),
    };
  });
  assert.ok(seen.far > 0.01 && seen.ahead > 0.999, JSON.stringify(seen));
  assert.ok(Math.abs(seen.angle - 30) < 0.01 && seen.side > 0, JSON.stringify(seen));
  assert.ok(seen.stays < 1e-6, JSON.stringify(seen));
}

// A unit of the owner's file makes the scene as large as it is. Pictures that come late get fewer pixels.
async function checkUnitAndPace(page) {
  await page.evaluate(() => {
    window.lumatlas.setQuality('auto');
    window.lumatlasTools.measuring.setUnit({name: 'm', length: 0.5});
  });
  await begin(page);
  const seen = await page.evaluate(async (ipd) => {
    const sizes = [];
    for (let i = 0; i < 12; ++i) {
      await window.nextFrame();
      sizes.push(window.lumatlas.target.width);
    }
    const frame = await window.eyes();
    const [left, right] = [-1, 1].map((side) => window.ordinary(frame, side * ipd / 2 / 0.5));
    return {sizes, apart: window.apart(frame.pictures[0], left), other: window.apart(frame.pictures[0], right),
            bytes: window.lumatlas.renderer.mostBytes, allowed: window.lumatlas.memory << 20};
  }, IPD);
  assert.ok(seen.sizes.at(-1) < seen.sizes[0], JSON.stringify(seen.sizes));
  assert.ok(seen.apart < seen.other, JSON.stringify(seen));
  assert.ok(seen.bytes <= seen.allowed, JSON.stringify(seen));
}

// After the end the canvas shows the page's picture again, sharp.
async function checkEnd(page) {
  await end(page);
  await page.waitForFunction(() => window.lumatlas.still === 'done', {timeout: 60000});
  const seen = await page.evaluate(() => {
    const {canvas} = window.lumatlas;
    const box = canvas.getBoundingClientRect();
    return {
      pressed: document.getElementById('headset').getAttribute('aria-pressed'), width: canvas.width - Math.round(box.width),
    };
  });
  assert.deepEqual(seen, {pressed: 'false', width: 0});
}

// A GPU that is lost ends the session; the page draws again once it is back.
async function checkLoss(page) {
  await begin(page);
  await page.evaluate(() => {
    window.loss = window.lumatlas.gl.getExtension('WEBGL_lose_context');
    window.loss.loseContext();
  });
  await page.waitForFunction(() => document.documentElement.dataset.headset === 'rests');
  await page.evaluate(() => setTimeout(() => window.loss.restoreContext(), 100));
  await page.waitForFunction(() => document.documentElement.dataset.gpu === 'there' && window.lumatlas.still === 'done',
                             {timeout: 60000});
}

export async function checkHeadset(page, picture) {
  await page.waitForFunction(() => document.documentElement.dataset.state === 'complete', {timeout: 60000});
  await page.waitForFunction(() => window.lumatlas.still === 'done', {timeout: 60000});
  await page.waitForSelector('#headset:not([hidden])', {timeout: 10000});
  await page.evaluate(prepare);
  await checkEyes(page, picture);
  await checkSticks(page);
  await checkEnd(page);
  await checkUnitAndPace(page);
  await checkEnd(page);
  await checkLoss(page);
}
