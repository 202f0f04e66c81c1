// SPDX-License-Identifier: GPL-3.0-or-later
// Firefox, which has WebGL only on a display: Xvfb is one without a screen.
import {spawn} from 'node:child_process';
import {accessSync, constants} from 'node:fs';
import {delimiter, join} from 'node:path';

// Returns the path of the first of these programs; null: there is none.
export function programOf(...names) {
  for (const name of names) {
    for (const folder of (process.env.PATH ?? '').split(delimiter)) {
      try {
        accessSync(join(folder, name), constants.X_OK);
        return join(folder, name);
      } catch {
        // The next one.
      }
    }
  }
  return null;
}

// Starts a display. Resolves with its name and what ends it.
async function display(xvfb) {
  const program = spawn(xvfb, ['-displayfd', '1', '-screen', '0', '1024x768x24', '-nolisten', 'tcp'],
                        {stdio: ['ignore', 'pipe', 'ignore']});
  const number = await new Promise((resolve, reject) => {
    program.stdout.once('data', (text) => resolve(String(text).trim()));
    program.once('error', reject);
    program.once('exit', () => reject(new Error('Xvfb ends before it has a display')));
  });
  return {name: `:${number}`, end: () => program.kill()};
}

// Starts Firefox from `puppeteer`, the module puppeteer-core. Resolves with {close, browser}; null: it is not there, which
// this says.
export async function startedFirefox(puppeteer) {
  const [firefox, xvfb] = [programOf('firefox-esr', 'firefox'), programOf('Xvfb')];
  if (!firefox || !xvfb) {
    console.log(`not checked here: the page in Firefox, there is no ${firefox ? 'Xvfb' : 'firefox-esr'}`);
    return null;
  }
  const screen = await display(xvfb);
  try {
    const browser = await puppeteer.launch({
      browser: 'firefox', executablePath: firefox, headless: false, env: {...process.env, DISPLAY: screen.name},
      // Firefox mistrusts drivers that draw in software.
      extraPrefsFirefox: {'webgl.force-enabled': true}, protocolTimeout: 120000,
    });
    return {browser, close: () => browser.close().finally(screen.end)};
  } catch (error) {
    screen.end();
    throw error;
  }
}
