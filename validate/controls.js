// What hands do to a viewer (validate/viewer.js), and how one begins.
'use strict';

function choose(v, view) {
  v.view = view;
  v.stages[1].hidden = view !== 'sides';
  for (const element of v.root.querySelectorAll('[data-views]')) {
    element.hidden = !element.dataset.views.split(' ').includes(view);
  }
  play(v, false);
  develop(v);
  moveTo(v, v.x, v.y);
}

function swap(v) {
  v.swapped = !v.swapped;
  label(v);
  draw(v);
}

// Pictures never begin to change by themselves.
function play(v, on) {
  clearInterval(v.timer);
  v.timer = on ? setInterval(swap, 1000 / number(v, 'rate'), v) : 0;
  control(v, 'play').setAttribute('aria-pressed', on);
  control(v, 'play').textContent = on ? 'Stop' : 'Play';
}

function fit(v) {
  v.zoom = 1;
  moveTo(v, v.width / 2, v.height / 2);
}

function reset(v) {
  for (const input of v.root.querySelectorAll('.controls input')) {
    input.value = input.defaultValue;
    input.checked = input.defaultChecked;
  }
  v.swapped = false;
  play(v, false);
  fit(v);
  develop(v);
}

function pressKey(v, key) {
  const way = {ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1]}[key];
  const [begin, end] = dividerSpan(v), {scale} = place(v), {width: across, height: down} = v.canvases[0];
  if (way && v.view === 'slider' && v.zoom === 1 && way[0]) {
    moveDivider(v, dividerX(v) + way[0] * (end - begin) / 50);
  } else if (way && v.zoom > 1) {
    moveTo(v, v.x + way[0] * across / scale / 8, v.y + way[1] * down / scale / 8);
  } else if (key === '+' || key === '=') {
    zoomBy(v, 2);
  } else if (key === '-') {
    zoomBy(v, 0.5);
  } else if (key === '0') {
    fit(v);
  } else {
    return false;
  }
  read(v, across / 2, down / 2);
  return true;
}

// ---- Fingers and mice

function pointOf(event, canvas) {
  const box = canvas.getBoundingClientRect();
  return {x: (event.clientX - box.left) * devicePixelRatio,
    y: (event.clientY - box.top) * devicePixelRatio};
}

// One pointer moves the divider or the picture, two enlarge it.
function drag(v, id, point) {
  const before = v.pointers.get(id), others = [...v.pointers].filter(([other]) => other !== id);
  v.pointers.set(id, point);
  if (others.length > 0) {
    const still = others[0][1], distance = p => Math.hypot(p.x - still.x, p.y - still.y);
    zoomBy(v, distance(point) / Math.max(distance(before), 1), (point.x + still.x) / 2,
           (point.y + still.y) / 2);
  } else if (v.onDivider) {
    moveDivider(v, point.x);
  } else {
    const {scale} = place(v);
    moveTo(v, v.x - (point.x - before.x) / scale, v.y - (point.y - before.y) / scale);
  }
}

function wirePointers(v, stage, canvas) {
  stage.addEventListener('pointerdown', event => {
    const point = pointOf(event, canvas);
    const near = Math.abs(point.x - dividerX(v)) < 24 * devicePixelRatio;
    v.onDivider = v.view === 'slider' && (v.zoom === 1 || near);
    v.pointers.set(event.pointerId, point);
    v.held = canvas;
    if (v.onDivider && v.pointers.size === 1) moveDivider(v, point.x);
  });
  stage.addEventListener('pointermove', event => {
    const point = pointOf(event, canvas);
    read(v, point.x, point.y);
  });
  stage.addEventListener('wheel', event => {
    if (!event.ctrlKey && document.activeElement !== stage) return;  // the page scrolls
    event.preventDefault();
    const point = pointOf(event, canvas);
    zoomBy(v, 2 ** (-event.deltaY / 200), point.x, point.y);
  }, {passive: false});
  stage.addEventListener('keydown', event => {
    if (!event.ctrlKey && !event.metaKey && pressKey(v, event.key)) event.preventDefault();
  });
}

// Anywhere on the page: a drag may leave its stage.
function wireDrags(v) {
  addEventListener('pointermove', event => {
    if (event.pointerType === 'mouse' && !event.buttons) v.pointers.clear();  // let go elsewhere
    if (v.pointers.has(event.pointerId)) drag(v, event.pointerId, pointOf(event, v.held));
  });
  for (const end of ['pointerup', 'pointercancel']) {
    addEventListener(end, event => v.pointers.delete(event.pointerId));
  }
}

// ---- Beginning

function wireControls(v) {
  const modes = v.root.querySelector('.modes');
  for (const [view, name] of Object.entries(views)) {
    if (view === 'maps' && v.maps.length === 0) continue;
    const choice = document.createElement('label');
    choice.innerHTML = `<input type="radio" name="view-${v.id}" value="${view}"><span>${name}</span>`;
    choice.firstChild.checked = view === 'slider';
    choice.firstChild.addEventListener('change', () => choose(v, view));
    modes.append(choice);
  }
  for (const map of v.maps) control(v, 'map').add(new Option(map.title));
  const on = (name, type, action) => control(v, name).addEventListener(type, () => action(v));
  on('split', 'input', () => { label(v); draw(v); });
  for (const name of ['exposure', 'gain', 'signed', 'map']) on(name, 'input', develop);
  on('rate', 'input', () => { label(v); if (v.timer) play(v, true); });
  on('play', 'click', () => play(v, !v.timer));
  on('swap', 'click', swap);
  on('in', 'click', () => zoomBy(v, 2));
  on('out', 'click', () => zoomBy(v, 0.5));
  on('one', 'click', () => zoomBy(v, devicePixelRatio / place(v).scale));
  on('fit', 'click', fit);
  on('reset', 'click', reset);
}

function openViewer(article, id, layers, gain, unit) {
  const root = document.getElementById('viewer').content.firstElementChild.cloneNode(true);
  const stages = [...root.querySelectorAll('.stage')];
  const [a, b, ...maps] = layers, {width, height} = a.picture;
  const painted = Object.fromEntries(
      ['a', 'b', 'other'].map(name => [name, document.createElement('canvas')]));
  const v = {id, root, stages, canvases: stages.map(stage => stage.querySelector('canvas')), a, b,
    maps, width, height, gain, unit, painted, view: 'slider', swapped: false, zoom: 1,
    x: width / 2, y: height / 2, timer: 0, pointers: new Map(), held: null, onDivider: false};
  for (const stage of stages) stage.style.aspectRatio = `${width} / ${height}`;
  wireControls(v);
  stages.forEach((stage, k) => wirePointers(v, stage, v.canvases[k]));
  wireDrags(v);
  article.querySelector('.stills').after(root);
  article.classList.add('live');
  choose(v, 'slider');
  new ResizeObserver(() => moveTo(v, v.x, v.y)).observe(stages[0]);
  article.dataset.state = 'ready';
}

async function openArticle(article, id, unpacked) {
  const holder = article.querySelector('.layers');
  const layers = await Promise.all([...holder.children].filter(e => e.dataset.packed).map(async e => {
    const key = e.dataset.packed;
    if (!unpacked.has(key)) unpacked.set(key, unpack(document.getElementById(key)));
    return {picture: await unpacked.get(key), white: Number(e.dataset.white), title: e.title, unit: ''};
  }));
  for (const layer of layers.slice(0, 2)) layer.unit = holder.dataset.unit;
  openViewer(article, id, layers, Number(holder.dataset.gain), holder.dataset.unit);
}

async function openAll() {
  const unpacked = new Map();
  const articles = [...document.querySelectorAll('.comparison')].filter(e => e.querySelector('.layers'));
  for (const [id, article] of articles.entries()) await openArticle(article, id, unpacked);
}

if ('DecompressionStream' in window) openAll();
