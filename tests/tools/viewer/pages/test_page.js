// SPDX-License-Identifier: GPL-3.0-or-later
// Shared by the pages of these tests: they report to the server what they see, and wait for events.

export const say = (name, body = '') => fetch('/said/' + name, {method: 'POST', body});

// Says each error and warning of a window.
export function listen(target) {
  target.addEventListener('error', (event) => say('problem', `${event.message ?? 'a file is missing'}\n`), true);
  target.addEventListener('unhandledrejection', (event) => say('problem', `${event.reason}\n`));
  for (const name of ['error', 'warn']) {
    const before = target.console[name];
    target.console[name] = (...words) => {
      say('problem', `${words.join(' ')}\n`);
      before.apply(target.console, words);
    };
  }
}

export const sleep = (ms) => new Promise((resolve) => setTimeout(resolve, ms));

export async function until(happened, what) {
  for (let i = 0; i < 1500; ++i) {
    if (await happened()) return;
    await sleep(100);
  }
  throw new Error(`${what} never happens`);
}

// Opens the site in the canvas "own", and tells the pictures of cameras.json that it draws.
export async function sayPictures(Viewer) {
  const viewer = new Viewer(
      document.getElementById('own'), {base: location.origin + '/', memory: 200, texels: 'rgb8'});
  await viewer.open();
  await viewer.load();
  const cameras = await (await fetch('/cameras.json')).json();
  for (const [number, camera] of cameras.entries()) await say(`picture-${number}`, viewer.pixels(camera));
  return {viewer, cameras};
}

// Opens the site's own page in a frame; the frame, once its script runs. Its camera rests.
export async function framed(address, width = 240, height = 180) {
  const frame = document.createElement('iframe');
  frame.width = width;
  frame.height = height;
  document.body.append(frame);
  const [path, hash = ''] = address.split('#');
  frame.src = `${path}${path.includes('?') ? '&' : '?'}drift=off${hash && '#' + hash}`;
  const there = () => frame.contentWindow.document.readyState === 'complete' &&
      frame.contentWindow.location.href !== 'about:blank';
  await until(there, `the page ${address}`);
  return frame;
}

// Runs the parts of a test one after another, and tells the end.
export async function run(...parts) {
  try {
    for (const part of parts) await part();
  } catch (error) {
    await say('problem', `${error.stack}\n`);
  }
  await say('done');
}
