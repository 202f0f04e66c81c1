// SPDX-License-Identifier: GPL-3.0-or-later
// The button that shows the model in a headset, where there is one.
import {button, part} from '../elements.js';
import {hasHeadset} from './headset.js';
/** @import {Texts} from '../texts/texts.js' */
/** @import {Headset} from './headset.js' */

/** @param {Headset} headset @param {Texts} texts */
export function connectHeadset(headset, texts) {
  const shown = button('headset');
  const line = part('headset-line');
  const look = async () => {
    shown.hidden = !await hasHeadset();
  };
  /** @param {string} words */
  const tell = (words) => {
    line.textContent = line.title = words;
    line.hidden = words === '';
  };
  shown.addEventListener('click', async () => {
    tell('');
    if (headset.session) return headset.end();
    try {
      await headset.begin();
    } catch (error) {
      tell(texts.say('headsetFails', {why: texts.of(error)}));
    }
  });
  headset.changed = () => {
    shown.setAttribute('aria-pressed', String(headset.session !== null));
    document.documentElement.dataset.headset = headset.session ? 'shows' : 'rests';
  };
  navigator.xr?.addEventListener('devicechange', look);
  return look();
}
