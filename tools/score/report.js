// Sorting, switching between methods, and comparing the pictures of a view in place. The page is complete without it.
'use strict';
(() => {
  const list = document.getElementById('views');
  const articles = [...list.querySelectorAll('article')];
  const buttons = [...document.querySelectorAll('#method button')];
  const order = document.getElementById('order');
  const score = document.getElementById('score');
  let method = 0;

  const number = (article, key) => {
    const text = article.dataset[key].split(' ')[method];
    return text === 'inf' ? Infinity : text === 'nan' ? NaN : Number(text);
  };

  function sort() {
    const sign = order.value === 'best' ? -1 : 1;
    const byName = (a, b) => Number(a.dataset.rank) - Number(b.dataset.rank);
    const byScore = (a, b) => {
      const x = number(a, score.value), y = number(b, score.value);
      if (isNaN(x) || isNaN(y)) return isNaN(x) - isNaN(y) || byName(a, b);
      return x === y ? byName(a, b) : sign * (x < y ? -1 : 1);
    };
    articles.sort(order.value === 'name' ? byName : byScore);
    list.append(...articles);
    score.disabled = order.value === 'name';
  }

  function choose(chosen) {
    method = chosen;
    buttons.forEach((button, i) => button.setAttribute('aria-pressed', i === method));
    for (const part of list.querySelectorAll('[data-method]')) {
      const shown = Number(part.dataset.method) === method;
      if (part.tagName === 'TR')
        part.classList.toggle('shown', shown);
      else
        part.hidden = !shown;
    }
    sort();
  }

  const dialog = document.querySelector('dialog');
  const large = dialog.querySelector('img');
  const title = dialog.querySelector('span');
  const kinds = [...dialog.querySelectorAll('button[data-kind]')];
  let links = [], current = 0;

  function look(index) {
    current = (index + links.length) % links.length;
    large.src = links[current].href;
    large.alt = links[current].dataset.kind;
    for (const button of kinds) {
      button.setAttribute('aria-pressed', button.dataset.kind === links[current].dataset.kind);
      button.hidden = !links.some(link => link.dataset.kind === button.dataset.kind);
    }
  }

  function open(link) {
    const row = link.closest('.row');
    links = [...row.querySelectorAll('a[data-kind]')];
    title.textContent = row.closest('article').dataset.name + ' \u2013 ' + buttons[method].textContent;
    look(links.indexOf(link));
    dialog.showModal();
  }

  list.addEventListener('click', event => {
    const link = event.target.closest('a[data-kind]');
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
  dialog.querySelector('button.close').addEventListener('click', () => dialog.close());
  dialog.addEventListener('keydown', event => {
    const step = {ArrowRight: 1, ArrowLeft: -1}[event.key];
    if (step) {
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
