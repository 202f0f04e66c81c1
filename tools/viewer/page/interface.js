// SPDX-License-Identifier: GPL-3.0-or-later
// What is around the picture: progress, buttons, thumbnails, legend, messages.

const LEGENDS = {
  picture: '',
  winner: 'One colour for each photograph: the one that counts most here. Grey: none.',
  weights: 'Red, green, blue: what the best, second and third photograph count.',
  coverage: 'How many photographs show this place: red one, yellow four, green eight and more. Grey: none.',
  geometry: 'The mesh alone.',
  colours: 'The mean of all photographs, as any other program shows it.',
};

const element = (id) => document.getElementById(id);

export class Interface {
  // `actions`: {mode(name), quality(name), jump(slot), save(), walk(), hold(), memory()}
  constructor(actions) {
    this.actions = actions;
    element('mode').addEventListener('change', (event) => actions.mode(event.target.value));
    element('quality').addEventListener('change', (event) => actions.quality(event.target.value));
    element('save').addEventListener('click', () => actions.save());
    element('walk').addEventListener('click', () => actions.walk());
    element('hold').addEventListener('click', () => actions.hold());
    element('full').addEventListener('click', () => this.toggleFullScreen());
    element('views').addEventListener('click', () => this.toggleThumbnails());
    element('help').addEventListener('click', () => {
      element('memory').textContent = actions.memory();
      element('keys').showModal();
    });
    element('understood').addEventListener('click', () => {
      element('notice').hidden = true;
    });
    element('full').hidden = !document.fullscreenEnabled;
  }

  toggleFullScreen() {
    if (document.fullscreenElement) return document.exitFullscreen();
    return document.documentElement.requestFullscreen().catch(() => {});  // the browser may say no
  }

  toggleThumbnails() {
    const strip = element('thumbnails');
    strip.hidden = !strip.hidden;
    element('views').setAttribute('aria-expanded', String(!strip.hidden));
  }

  showThumbnails(scene, files) {
    const strip = element('thumbnails');
    const known = new Map([...strip.children].map((button) => [button.dataset.content, button]));
    const buttons = scene.views.map((view, slot) => {
      return view && (known.get(`${slot} ${view.thumbnail}`) ?? this.thumbnail(view, slot, files));
    }).filter(Boolean);
    if (buttons.length !== strip.children.length || buttons.some((button, i) => button !== strip.children[i])) {
      strip.replaceChildren(...buttons);
    }
  }

  thumbnail(view, slot, files) {
    const button = document.createElement('button');
    const image = document.createElement('img');
    image.loading = 'lazy';
    files.show(image, view.thumbnail);
    image.alt = '';
    button.title = view.name;
    button.dataset.slot = slot;
    button.dataset.content = `${slot} ${view.thumbnail}`;
    button.setAttribute('aria-label', `Photograph ${view.name}`);
    button.append(image);
    button.addEventListener('click', () => this.actions.jump(slot));
    return button;
  }

  showMode(mode) {
    element('mode').value = mode;
    element('legend').textContent = LEGENDS[mode];
    element('legend').hidden = LEGENDS[mode] === '';
  }

  showOrbits(orbits) {
    element('walk').setAttribute('aria-pressed', String(!orbits));
    element('walk').title = orbits ? 'A drag turns around the surface' : 'A drag turns the head';
  }

  showHold(on) {
    element('hold').setAttribute('aria-pressed', String(on));
    element('hold').title = on ? 'Where nobody photographed one comes back' : 'One may go anywhere';
  }

  // `done` of `total` photographs are there. `ended`: there is nothing to wait for.
  showProgress(text, done, total, ended = done >= total) {
    const bar = element('progress');
    bar.max = Math.max(total, 1);
    bar.value = done;
    bar.hidden = ended;
    element('status').textContent = ended ? '' : text;
  }

  // What could not be loaded, in one line; '': nothing is missing.
  showLosses(line) {
    element('losses').textContent = line;
    element('losses').title = line;
    element('losses').hidden = line === '';
  }

  showNote(text) {
    element('status').textContent = text;
  }

  // Until it is understood; '': there is nothing to say any more. What is to be typed stands between ` and `.
  showNotice(text) {
    if (this.notice === text) return;
    this.notice = text;
    const parts = text.split('`').map((part, i) => {
      const shown = document.createElement(i % 2 ? 'code' : 'span');
      shown.textContent = part;
      return shown;
    });
    element('notice-text').replaceChildren(...parts);
    element('notice').hidden = text === '';
  }

  showPoster(files, name) {
    files.show(element('poster'), name);
    element('poster').hidden = false;
  }

  hidePoster() {
    element('poster').hidden = true;
  }

  // Instead of the picture and of what would do nothing any more.
  showFailure(text) {
    element('message').textContent = text;
    element('message').hidden = false;
    for (const tag of ['nav', 'footer']) document.querySelector(tag).hidden = true;
    element('progress').hidden = true;
    element('status').textContent = '';
  }
}
