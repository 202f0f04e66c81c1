// SPDX-License-Identifier: GPL-3.0-or-later
// Keeps a viewer drawing, in the size of its canvas, and lets visitors move its camera.
import {Controls} from './controls.js';
/** @import {Viewer} from './viewer.js' */

// Draws what the viewer has until it is closed, and moves its camera by mouse, touch and keyboard. `drawn` is called
// before each frame.
/** @param {Viewer} viewer @param {() => void} drawn */
export function interact(viewer, drawn = () => {}) {
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
    return controls.advance(seconds);
  });
}
