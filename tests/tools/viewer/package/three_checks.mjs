// SPDX-License-Identifier: GPL-3.0-or-later
// Checks of LumatlasObject in the example for three.js, which leaves {renderer, scene, camera, model, balls} in
// window.example.
import assert from 'node:assert/strict';

// Functions for the page: `picture()` renders and returns the canvas' pixels from the bottom up.
function prepare() {
  const {renderer, scene, camera} = window.example;
  const gl = renderer.getContext();
  const [width, height] = [gl.drawingBufferWidth, gl.drawingBufferHeight];
  window.picture = () => {
    renderer.render(scene, camera);
    const pixels = new Uint8Array(4 * width * height);
    gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
    return pixels;
  };
  // Share of pixels that differ by more than `levels`.
  window.different = (a, b, levels) => {
    let count = 0;
    for (let i = 0; i < a.length; i += 4) {
      if ([0, 1, 2].some((channel) => Math.abs(a[i + channel] - b[i + channel]) > levels)) ++count;
    }
    return count / (width * height);
  };
  // The pixel that shows a point of the world.
  window.pixelAt = (pixels, point) => {
    const [x, y] = point.clone().project(camera).toArray().map((v) => (v + 1) / 2);
    const at = 4 * (Math.floor(y * height) * width + Math.floor(x * width));
    return [...pixels.subarray(at, at + 3)];
  };
}

// The red ball hides the model; of the blue one, the part in the door is seen, and the wall hides the rest.
async function checkDepth(page) {
  const seen = await page.evaluate(() => {
    const {model, balls} = window.example;
    const {before, behind} = balls;
    const withBalls = window.picture();
    before.visible = behind.visible = false;
    const alone = window.picture();
    before.visible = behind.visible = true;
    model.visible = false;
    const ballsOnly = window.picture();
    model.visible = true;
    let [blue, hidden, wrong] = [0, 0, 0];
    for (let i = 0; i < alone.length; i += 4) {
      if (!(ballsOnly[i + 2] > 100 && ballsOnly[i + 2] > 2 * ballsOnly[i])) continue;
      const same = (other) => [0, 1, 2].every((c) => Math.abs(withBalls[i + c] - other[i + c]) <= 2);
      if (same(ballsOnly)) ++blue;
      else if (same(alone)) ++hidden;
      else ++wrong;
    }
    const red = window.pixelAt(withBalls, before.position);
    return {blue, hidden, wrong, red, redBall: window.pixelAt(ballsOnly, before.position)};
  });
  assert.deepEqual(seen.red, seen.redBall);
  const all = seen.blue + seen.hidden + seen.wrong;
  assert.ok(seen.blue > 0.1 * all && seen.hidden > 0.1 * all, JSON.stringify(seen));
  assert.ok(seen.wrong < 0.1 * all, JSON.stringify(seen));  // pixels at the ball's rim, which are smoothed
}

// A model and a camera that are moved together show the same picture, whatever the model's place, turn and size.
async function checkTransform(page) {
  const seen = await page.evaluate(() => {
    const {model, balls, camera} = window.example;
    balls.before.visible = balls.behind.visible = false;
    const straight = window.picture();
    const Matrix4 = model.matrixWorld.constructor;
    const [Vector3, Quaternion] = [model.position.constructor, model.quaternion.constructor];
    const turn = new Quaternion().setFromAxisAngle(new Vector3(1, 2, 3).normalize(), 1);
    const moved = new Matrix4().compose(new Vector3(3, -2, 5), turn, new Vector3(2, 2, 2));
    const [ofModel, ofCamera] = [model, camera].map((object) => object.matrix.clone());
    for (const object of [model, camera]) {
      object.applyMatrix4(moved);
      object.updateMatrixWorld(true);
    }
    camera.scale.set(1, 1, 1);
    const together = window.picture();
    model.scale.set(1, 2, 1);
    const stretched = window.picture();
    const {errors} = model;
    for (const [object, matrix] of [[model, ofModel], [camera, ofCamera]]) {
      matrix.decompose(object.position, object.quaternion, object.scale);
      object.updateMatrixWorld(true);
    }
    const back = window.picture();
    balls.before.visible = balls.behind.visible = true;
    return {
      moved: window.different(straight, together, 3), back: window.different(straight, back, 0), errors,
      stretched: window.different(straight, stretched, 3),
    };
  });
  assert.ok(seen.moved < 0.005, JSON.stringify(seen));
  assert.equal(seen.back, 0);
  assert.ok(seen.stretched > 0.5);
  assert.match(seen.errors[0], /not stretched/);
}

// In a render target, in half of the canvas, with fewer pixels: the same picture.
async function checkTargets(page) {
  const seen = await page.evaluate(() => {
    const {renderer, scene, camera, model} = window.example;
    const whole = window.picture();
    const Size = model.position.constructor;
    const half = renderer.getSize(new Size()).multiplyScalar(0.5);
    renderer.setViewport(half.x, 0, half.x, half.y);
    const corner = window.picture();
    renderer.setViewport(0, 0, 2 * half.x, 2 * half.y);
    const gl = renderer.getContext();
    const [width, height] = [gl.drawingBufferWidth, gl.drawingBufferHeight];
    let [sum, count] = [0, 0];
    for (let y = 0; y < height / 2; ++y) {
      for (let x = 0; x < width / 2; ++x, ++count) {
        const [from, to] = [4 * (2 * y * width + 2 * x), 4 * (y * width + x + width / 2)];
        sum += Math.abs(whole[from + 1] - corner[to + 1]);
      }
    }
    model.resolution = 0.5;
    const coarse = window.picture();
    model.resolution = 1;
    renderer.render(scene, camera);
    return {corner: sum / count, coarse: window.different(whole, coarse, 60)};
  });
  assert.ok(seen.corner < 12, JSON.stringify(seen));
  assert.ok(seen.coarse < 0.1, JSON.stringify(seen));
}

// What is three's own is drawn as before once the model is gone, and nothing of the model stays on the GPU.
export async function checkEnd(page) {
  const seen = await page.evaluate(() => {
    const {model, renderer, scene} = window.example;
    renderer.setAnimationLoop(null);
    model.visible = false;
    const hidden = window.picture();
    const before = renderer.getContext().objects;
    model.dispose();
    const gone = window.picture();
    const left = {objects: before - renderer.getContext().objects, children: scene.children.includes(model)};
    return {...left, different: window.different(hidden, gone, 0), error: renderer.getContext().getError()};
  });
  assert.ok(seen.objects > 20, JSON.stringify(seen));
  assert.equal(seen.children, false);
  assert.equal(seen.different, 0);
  assert.equal(seen.error, 0);
}

export async function checkThree(page) {
  await page.waitForFunction(() => window.example, {timeout: 60000});
  await page.evaluate(async () => {
    const {model, renderer} = window.example;
    await model.loaded;
    renderer.setAnimationLoop(null);  // each check renders when it wants to
    while (!model._viewer.shown.pictures) {
      await new Promise((resolve) => setTimeout(resolve, 100));
      renderer.render(window.example.scene, window.example.camera);
    }
  });
  await page.evaluate(prepare);
  await checkDepth(page);
  await checkTransform(page);
  await checkTargets(page);
}
