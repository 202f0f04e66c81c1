// Sorting, switching between methods, and comparing the pictures of a view in place. The page is complete without it.
'use strict';
(() => {
  // Returns an element that the report's page is sure to have.
  /**
   * @template {Element} T
   * @param {ParentNode} parent
   * @param {string} selector
   * @param {new () => T} type
   * @returns {T}
   */
  function found(parent, selector, type) {
    const element = parent.querySelector(selector);
    if (!(element instanceof type)) throw new Error(`the report has no ${selector}`);
    return element;
  }

  /** @param {ParentNode} parent @param {string} selector @returns {HTMLElement[]} */
  const all = (parent, selector) =>
      [...parent.querySelectorAll(selector)].filter(element => element instanceof HTMLElement);

  const list = found(document, '#views', HTMLElement);
  const articles = all(list, 'article');
  const buttons = all(document, '#method button');
  const order = found(document, '#order', HTMLSelectElement);
  const score = found(document, '#score', HTMLSelectElement);
  let method = 0;

  /** @param {HTMLElement} article @param {string} key */
  const number = (article, key) => {
    const text = (article.dataset[key] ?? '').split(' ')[method];
    return text === 'inf' ? Infinity : text === 'nan' ? NaN : Number(text);
  };

  function sort() {
    const sign = order.value === 'best' ? -1 : 1;
    /** @param {HTMLElement} a @param {HTMLElement} b */
    const byName = (a, b) => Number(a.dataset.rank) - Number(b.dataset.rank);
    /** @param {HTMLElement} a @param {HTMLElement} b */
    const byScore = (a, b) => {
      const x = number(a, score.value), y = number(b, score.value);
      if (isNaN(x) || isNaN(y)) return Number(isNaN(x)) - Number(isNaN(y)) || byName(a, b);
      return x === y ? byName(a, b) : sign * (x < y ? -1 : 1);
    };
    articles.sort(order.value === 'name' ? byName : byScore);
    list.append(...articles);
    score.disabled = order.value === 'name';
  }

  /** @param {number} chosen */
  function choose(chosen) {
    method = chosen;
    buttons.forEach((button, i) => button.setAttribute('aria-pressed', String(i === method)));
    for (const part of all(list, '[data-method]')) {
      const shown = Number(part.dataset.method) === method;
      if (part.tagName === 'TR')
        part.classList.toggle('shown', shown);
      else
        part.hidden = !shown;
    }
    sort();
  }

  const dialog = found(document, 'dialog', HTMLDialogElement);
  const large = found(dialog, 'img', HTMLImageElement);
  const title = found(dialog, 'span', HTMLSpanElement);
  const kinds = all(dialog, 'button[data-kind]');
  /** @type {HTMLElement[]} */
  let links = [];
  let current = 0;

  /** @param {number} index */
  function look(index) {
    current = (index + links.length) % links.length;
    const {kind = ''} = links[current].dataset;
    large.src = links[current].getAttribute('href') ?? '';
    large.alt = kind;
    for (const button of kinds) {
      button.setAttribute('aria-pressed', String(button.dataset.kind === kind));
      button.hidden = !links.some(link => link.dataset.kind === button.dataset.kind);
    }
  }

  /** @param {HTMLElement} link */
  function open(link) {
    const row = link.closest('.row');
    if (!row) return;
    links = all(row, 'a[data-kind]');
    title.textContent = row.closest('article')?.dataset.name + ' \u2013 ' + buttons[method].textContent;
    look(links.indexOf(link));
    dialog.showModal();
  }

  list.addEventListener('click', event => {
    if (!(event.target instanceof Element)) return;
    /** @type {HTMLElement | null} */
    const link = event.target.closest('a[data-kind]');
    /** @type {HTMLElement | null} */
    const line = event.target.closest('tr[data-method]');
    if (link && !event.ctrlKey && !event.metaKey && !event.shiftKey) {
      event.preventDefault();
      open(link);
    } else if (line) {
      const top = line.getBoundingClientRect().top;
      choose(Number(line.dataset.method));
      window.scrollBy(0, line.getBoundingClientRect().top - top);  // the sorting has moved it
    }
  });
  large.addEventListener('click', () => look(current + 1));
  for (const button of kinds) {
    button.addEventListener('click', () => look(links.findIndex(link => link.dataset.kind === button.dataset.kind)));
  }
  found(dialog, 'button.close', HTMLButtonElement).addEventListener('click', () => dialog.close());
  dialog.addEventListener('keydown', event => {
    const step = event.key === 'ArrowRight' ? 1 : event.key === 'ArrowLeft' ? -1 : 0;
    if (step !== 0) {
      event.preventDefault();
      look(current + step);
    }
  });
  buttons.forEach((button, i) => button.addEventListener('click', () => choose(i)));
  order.addEventListener('change', sort);
  score.addEventListener('change', sort);

  document.documentElement.classList.add('script');
  choose(0);
  if (location.hash) document.getElementById(location.hash.slice(1))?.scrollIntoView();
})();
