// SPDX-License-Identifier: GPL-3.0-or-later
// Keeps a viewer drawing, in the size of its canvas, and lets visitors move its camera.
import {Controls} from './controls.js';
/** @import {Drift} from './drift.js' */
/** @import {Viewer} from './viewer.js' */

// Draws what the viewer has until it is closed, and moves its camera by mouse, touch and keyboard. `drawn` is called
// before each frame. The camera moves by itself as long as `drift` says that it does.
/** @param {Viewer} viewer @param {() => void} drawn @param {Drift | null} drift */
export function interact(viewer, drawn = () => {}, drift = null) {
  const {canvas, navigation} = viewer;
  const controls = new Controls(canvas, navigation, (x, y) => viewer.pick(x, y), () => viewer.moved());
  const observer = new ResizeObserver(() => viewer.resize());
  observer.observe(canvas);
  viewer.closing.signal.addEventListener('abort', () => {
    observer.disconnect();
    controls.close();
  });
  viewer.run((seconds) => {
    drawn();
    if (!drift?.advance(seconds)) return controls.advance(seconds);
    viewer.invalidate();  // not moved(): the address stays as it is
    return false;
  });
}
