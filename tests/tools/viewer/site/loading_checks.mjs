// SPDX-License-Identifier: GPL-3.0-or-later
// Checks of what a visitor sees while a model comes over a slow network.
import assert from 'node:assert/strict';
import {complete} from './drift_checks.mjs';

const BYTES_A_SECOND = 400e3;

export const withSlowNetwork = (page) => page.emulateNetworkConditions(
    {download: BYTES_A_SECOND, upload: BYTES_A_SECOND, latency: 20});

// A poster is there before the mesh, and the bar moves while the mesh comes, as it does while photographs come.
export async function checkLoading(page, picture) {
  const seen = await page.evaluate(async () => {
    const [bar, poster] = ['progress', 'poster'].map((id) => document.getElementById(id));
    const shares = new Set();
    // Seconds since the page was asked for, and bytes that came, when it shows something for the first time.
    const times = {};
    const note = (what, isShown) => {
      if (times[what] || !isShown) return;
      const files = [...performance.getEntriesByType('navigation'), ...performance.getEntriesByType('resource')];
      times[what] = [performance.now() / 1000, files.reduce((sum, file) => sum + file.transferSize, 0) / 1e6];
    };
    while (!times.photograph) {
      if (!times.mesh) shares.add(bar.value / bar.max);
      note('poster', !poster.hidden && poster.complete && poster.naturalWidth > 0);
      note('mesh', window.lumatlas?.hasMesh);
      note('photograph', window.lumatlas?.shown.pictures);
      await new Promise((resolve) => setTimeout(resolve, 50));
    }
    return {shares: [...shares], times};
  });
  const times = Object.entries(seen.times).map(
      ([what, [seconds, megabytes]]) => `${what} after ${seconds.toFixed(1)} s and ${megabytes.toFixed(2)} MB`);
  console.log(`loading at ${BYTES_A_SECOND / 1e3} kB/s, files as they lie: ${times.join(', ')}`);
  await picture();
  assert.ok(seen.times.poster[0] < seen.times.mesh[0], 'the poster is seen first');
  assert.ok(seen.shares.length > 3, `the bar stood at ${seen.shares}`);
  assert.deepEqual(seen.shares, [...seen.shares].sort((a, b) => a - b));
  await page.emulateNetworkConditions(null);
  await complete(page);
  assert.equal(await page.$eval('#progress', (bar) => bar.hidden), true);
}
