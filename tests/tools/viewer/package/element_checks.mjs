// SPDX-License-Identifier: GPL-3.0-or-later
// Checks of <lumatlas-viewer> on a page that shows one with the id "model".
import assert from 'node:assert/strict';

// Makes the model's element smaller than the example does, because software draws it, and waits until the page says what
// it does once the model is there.
async function loaded(page) {
  await page.addStyleTag({content: '#model { width: 240px; height: 180px }'});
  await page.waitForFunction(
      () => document.getElementById('status').textContent.includes('photographed nearby'), {timeout: 60000});
}

// The state that the page's script sees after loading.
async function checkState(page) {
  const seen = await page.evaluate(async () => {
    const model = document.getElementById('model');
    const {views, errors, camera} = model;
    const blob = await model.screenshot();
    return {views, errors, camera, type: blob.type, bytes: blob.size, coverage: await model.coverage()};
  });
  assert.equal(seen.views.length, 8);
  assert.deepEqual(seen.errors, []);
  assert.equal(seen.type, 'image/png');
  assert.ok(seen.bytes > 20000, `a picture of ${seen.bytes} bytes`);
  assert.ok(seen.coverage > 0.8 && seen.coverage <= 1, `coverage ${seen.coverage} at a photograph`);
  assert.ok(Math.abs(Math.hypot(...seen.camera.direction) - 1) < 1e-6);
}

// A camera that is set is the one that is got, and a jump arrives at its photograph.
async function checkCamera(page) {
  const seen = await page.evaluate(async () => {
    const model = document.getElementById('model');
    const first = model.camera;
    const changes = [];
    model.addEventListener('viewchange', ({detail}) => changes.push(detail.position));
    await model.goTo(model.views[3], {duration: 200});
    const third = model.camera;
    model.camera = first;
    const again = model.camera;
    model.camera = {target: first.position.map((p, axis) => p + 2 * first.direction[axis]), fov: 30};
    const {fov, direction} = model.camera;
    const wrong = await Promise.all([model.goTo('no such photograph'), model.goTo({fov: 200})].map(
        (going) => going.then(() => '', (error) => error.name)));
    model.camera = first;
    return {first, third, again, fov, direction, changes: changes.length, wrong};
  });
  const apart = (a, b) => Math.hypot(...a.map((v, i) => v - b[i]));
  assert.ok(apart(seen.first.position, seen.third.position) > 0.01);
  for (const name of ['position', 'direction', 'up']) assert.ok(apart(seen.first[name], seen.again[name]) < 1e-6, name);
  assert.ok(apart(seen.first.direction, seen.direction) < 1e-6);
  assert.equal(seen.fov, 30);
  assert.ok(seen.changes > 0);
  assert.deepEqual(seen.wrong, ['RangeError', 'RangeError']);
}

// The host's CSS does not reach inside, and nothing of the element leaks out.
async function checkStyle(page) {
  await page.addStyleTag({content: 'canvas, div, p, img, progress { display: none !important; width: 3px !important }'});
  const seen = await page.evaluate(() => {
    const model = document.getElementById('model');
    const {width, height} = model.shadowRoot.querySelector('canvas').getBoundingClientRect();
    return {width, height, outside: document.querySelectorAll('canvas').length};
  });
  assert.deepEqual(seen, {width: 240, height: 180, outside: 0});
}

// A wheel scrolls the page until the visitor has turned to the model; controls="none" leaves all to the page.
async function checkWheel(page) {
  const seen = await page.evaluate(async () => {
    const model = document.getElementById('model');
    const canvas = model.shadowRoot.querySelector('canvas');
    const wheel = () => {
      const event = new WheelEvent('wheel', {deltaY: 10, bubbles: true, cancelable: true, composed: true});
      canvas.dispatchEvent(event);
      return event.defaultPrevented;
    };
    const before = wheel();
    canvas.focus();
    const focused = wheel();
    canvas.blur();
    model.setAttribute('controls', 'none');
    const still = [canvas.tabIndex, getComputedStyle(canvas).pointerEvents];
    model.removeAttribute('controls');
    return {before, focused, still, again: getComputedStyle(canvas).pointerEvents};
  });
  assert.deepEqual(seen, {before: false, focused: true, still: [-1, 'none'], again: 'auto'});
}

// The attribute "drift" moves the camera until it is touched, or the attribute goes.
async function checkDrift(page) {
  const seen = await page.evaluate(async () => {
    const model = document.getElementById('model');
    const without = model._shown.drift;
    const states = [];
    model.setAttribute('drift', '');
    for (const end of [() => model.removeAttribute('drift'), () => {
      model.shadowRoot.querySelector('canvas').dispatchEvent(new PointerEvent('pointerdown', {pointerId: 1}));
    }]) {
      await model.load('/model/');
      await model.coverage();
      states.push(model._shown.drift.state);
      end();
      states.push(model._shown.drift.state);
      model.setAttribute('drift', '');
    }
    model.removeAttribute('drift');
    return {without, states};
  });
  assert.equal(seen.without, null);
  assert.deepEqual(seen.states, ['waits', 'ended', 'waits', 'ended']);
}

// A second element shows a .glb at the same time; what is taken away leaves nothing on the GPU.
async function checkLifetime(page) {
  const seen = await page.evaluate(async () => {
    const model = document.getElementById('model');
    const canvasOf = (element) => element.shadowRoot.querySelector('canvas');
    const objects = (canvas) => canvas.getContext('webgl2').objects;
    const settled = () => new Promise((resolve) => setTimeout(resolve, 50));
    const second = document.createElement('lumatlas-viewer');
    second.style.width = '160px';
    document.body.append(second);
    await second.load('/others/model.glb');
    const {views} = second;
    const canvas = canvasOf(second);
    document.body.prepend(second);  // moved within the document: it keeps its model
    await settled();
    const there = {kept: canvasOf(second) === canvas, objects: objects(canvas)};
    second.remove();
    await settled();
    const removed = objects(canvas);
    const first = canvasOf(model);
    const before = objects(first);
    const loading = model.load('/others/site/');
    await settled();
    const replaced = objects(first);
    await loading;
    const coverage = await model.coverage();
    await model.screenshot();  // for the picture of this test
    return {views: views.length, there, removed, before, replaced, coverage};
  });
  assert.equal(seen.views, 8);
  assert.ok(seen.there.kept);
  assert.ok(seen.there.objects > 20 && seen.before > 20, JSON.stringify(seen));
  assert.equal(seen.removed, 0);
  assert.equal(seen.replaced, 0);
  assert.ok(seen.coverage > 0.8);
}

// An element shows what the owner's file says, unless its attribute says otherwise. A wrong file is one sentence.
async function checkOwner(page) {
  const seen = await page.evaluate(async () => {
    const model = document.getElementById('model');
    const inside = (selector) => [...model.shadowRoot.querySelectorAll(selector)];
    const hides = () => {
      const {pieces} = model._shown.viewer.renderer.surface;
      const sum = (lists) => lists.flat().reduce((a, b) => a + b, 0);
      const all = [...pieces.values()];
      return sum(all.map(({shown}) => shown)) / sum(all.map(({counts}) => counts));
    };
    const errors = [];
    const note = ({detail}) => errors.push(detail);
    model.addEventListener('error', note);
    await model.load('/others/owned/');
    const {owner, camera} = model;
    const canvas = model.shadowRoot.querySelector('canvas');
    await model.screenshot();
    const [first] = inside('.mark');
    const label = [canvas.getAttribute('aria-label'), first.getAttribute('aria-label'), first.style.transform !== ''];
    first.click();
    const opened = [inside('#card')[0].hidden, inside('#card')[0].innerText];
    await new Promise((resolve) => setTimeout(resolve, 1500));
    const flown = model.camera;
    inside('#card button')[0].click();
    const closed = inside('#card')[0].hidden;
    const part = hides();
    await model.screenshot();  // for the picture of this test
    model.setAttribute('owner', 'off');
    await model.load('/others/owned/');
    await model.coverage();  // which the page asks for too
    const off = {marks: inside('.mark').length, part: hides(), fov: model.camera.fov, title: model.owner.title};
    model.setAttribute('owner', '/others/wrong.page.json');
    await model.load('/others/owned/');
    await model.coverage();
    const wrong = [model.errors, inside('#line')[0].textContent, errors.slice()];
    model.removeEventListener('error', note);
    model.removeAttribute('owner');
    return {owner, camera, label, opened, flown, closed, part, off, wrong};
  });
  assert.equal(seen.owner.title, 'A flat');
  assert.equal(seen.owner.annotations.length, 2);
  assert.deepEqual(seen.camera.position, [0.5, 0.25, 0.25]);
  assert.equal(seen.camera.fov, 70);
  assert.deepEqual(seen.label,
                   ['A flat. The scene. Drag to turn, arrow keys and W A S D to move.', 'Annotation 1: Wall', true]);
  assert.equal(seen.opened[0], false);
  assert.match(seen.opened[1], /Wall\s+It is a wall\./);
  assert.equal(seen.flown.fov, 60);
  assert.deepEqual(seen.flown.position, [0.25, 0.25, 0.5]);
  assert.equal(seen.closed, true);
  assert.ok(seen.part > 0.1 && seen.part < 0.9, `${seen.part} of the surface is shown`);
  assert.deepEqual({...seen.off, fov: seen.off.fov === 70}, {marks: 0, part: 1, fov: false, title: ''});
  const complaint = 'page.json: it has the unknown field "titel".';
  assert.deepEqual(seen.wrong, [[complaint], complaint, [{message: complaint, final: false}]]);
}

export async function checkElement(page) {
  await loaded(page);
  await checkState(page);
  await checkCamera(page);
  await checkStyle(page);
  await checkWheel(page);
  await checkOwner(page);
  await checkDrift(page);
  await checkLifetime(page);
}

// What the element says of models that cannot be had, and of one on another server that allows it. `servers` are the
// addresses of two others.
export async function checkNetwork(page, servers) {
  await loaded(page);
  const seen = await page.evaluate(async ({strict, open}) => {
    const model = document.getElementById('model');
    const events = [];
    model.addEventListener('error', ({detail}) => events.push(detail));
    const refused = [];
    for (const source of ['/nothing/', `${strict}/model/`]) {
      await model.load(source).catch((error) => refused.push(error.message));
    }
    const line = model.shadowRoot.querySelector('p').textContent;
    const {errors} = model;
    await model.load(`${open}/others/model.glb`);
    model.setAttribute('lang', 'de');
    const german = await model.load('/nothing/').catch(() => model.errors[0]);
    const label = model.shadowRoot.querySelector('canvas').getAttribute('aria-label');
    model.removeAttribute('lang');
    const early = model.load('/model/').catch((error) => error.name);
    await model.load('/others/site/');
    return {german, label, events, refused, line, errors, views: model.views.length, early: await early, last: model.errors};
  }, servers);
  assert.equal(seen.refused.length, 2);
  assert.match(seen.german, /das Modell|kann nicht geladen werden: der Server sagt 404/);
  assert.match(seen.label, /^Die Szene\./);
  assert.match(seen.refused[0], /404/);
  assert.match(seen.refused[1], /does not allow .*Access-Control-Allow-Origin/);
  assert.deepEqual(seen.events.slice(0, 2), seen.refused.map((message) => ({message, final: true})));
  assert.equal(seen.line, seen.refused[1]);
  assert.deepEqual(seen.errors, [seen.refused[1]]);
  assert.equal(seen.views, 8);
  assert.equal(seen.early, 'AbortError');
  assert.deepEqual(seen.last, []);
}
