// Lays the pictures of a comparison over each other (validate/report.h, Comparison), with controls
// from the page's <template id="viewer">. Where this does not run the page shows them as PNG.
// A layer is {picture, white, title}; layers are the judged, the reference, and the maps. A viewer v
// holds what is seen; its exposure, gain, divider and rate are the values of its controls.
'use strict';

const views = {slider: 'Slider', flicker: 'Flicker', sides: 'Side by side',
  difference: 'Difference', maps: 'Error maps'};
const clamp = (value, low, high) => Math.min(Math.max(value, low), high);
const short = number => Number.isFinite(number) ? String(Number(number.toPrecision(4))) : 'no number';
const control = (v, name) => v.root.querySelector(`[name=${name}]`);
const number = (v, name) => Number(control(v, name).value);
const chosenMap = v => v.maps[control(v, 'map').selectedIndex];

// ---- Where the picture lies on the stage, in pixels of the canvas

// `scale`: how large a pixel of the picture is; `left`, `top`: its first corner.
function place(v) {
  const {width: across, height: down} = v.canvases[0];
  const scale = Math.min(across / v.width, down / v.height) * v.zoom;
  return {scale, left: across / 2 - v.x * scale, top: down / 2 - v.y * scale};
}

// The divider's setting is a share of what is seen of the picture.
function dividerSpan(v) {
  const {scale, left} = place(v);
  return [Math.max(left, 0), Math.min(left + v.width * scale, v.canvases[0].width)];
}

function dividerX(v) {
  const [begin, end] = dividerSpan(v);
  return begin + (end - begin) * number(v, 'split') / 100;
}

function moveDivider(v, x) {
  const [begin, end] = dividerSpan(v);
  control(v, 'split').value = 100 * (x - begin) / (end - begin);
  label(v);
  draw(v);
}

// Takes the middle of the view to (x, y) of the picture, and keeps the picture on the stage.
function moveTo(v, x, y) {
  const {scale} = place(v), {width: across, height: down} = v.canvases[0];
  const keep = (value, size, extent) => size <= extent ? size / 2 :
      clamp(value, extent / 2, size - extent / 2);
  v.x = keep(x, v.width, across / scale);
  v.y = keep(y, v.height, down / scale);
  draw(v);
}

// What is at (x, y) of the stage stays there. A pixel grows to 64 of the screen's.
function zoomBy(v, factor, x = v.canvases[0].width / 2, y = v.canvases[0].height / 2) {
  const before = place(v);
  v.zoom = clamp(v.zoom * factor, 1, Math.max(1, 64 * v.zoom / before.scale));
  const step = 1 / before.scale - 1 / place(v).scale;
  moveTo(v, v.x + (x - v.canvases[0].width / 2) * step, v.y + (y - v.canvases[0].height / 2) * step);
}

// ---- What is seen

function drawLayer(v, canvas, layer, from = 0) {
  const context = canvas.getContext('2d'), {scale, left, top} = place(v);
  context.save();
  context.beginPath();
  context.rect(from, 0, canvas.width - from, canvas.height);
  context.clip();
  context.imageSmoothingEnabled = scale < 1;  // enlarged pixels are squares
  context.setTransform(scale, 0, 0, scale, left, top);
  context.drawImage(layer, 0, 0);
  context.restore();
}

function drawDivider(v) {
  const x = Math.round(dividerX(v)), context = v.canvases[0].getContext('2d');
  drawLayer(v, v.canvases[0], v.painted.b, x);
  for (const [color, half] of [['#000', 2], ['#fff', 1]]) {
    context.fillStyle = color;
    context.fillRect(x - half, 0, 2 * half, v.canvases[0].height);
  }
}

function draw(v) {
  v.stages.forEach((stage, k) => {
    v.canvases[k].width = Math.round(stage.clientWidth * devicePixelRatio);  // which clears it
    v.canvases[k].height = Math.round(stage.clientHeight * devicePixelRatio);
    stage.style.touchAction = v.zoom > 1 ? 'none' : 'pan-y';
  });
  if (!v.canvases[0].width) return;  // not shown, as on paper
  const {a, b, other} = v.painted;
  const first = {difference: other, maps: other, flicker: v.swapped ? b : a}[v.view] || a;
  drawLayer(v, v.canvases[0], first);
  if (v.view === 'slider') drawDivider(v);
  if (v.view === 'sides') drawLayer(v, v.canvases[1], b);
}

// Paints the layers anew, as exposure, gain and map want them.
function develop(v) {
  const {a, b, other} = v.painted, gain = 2 ** number(v, 'gain');
  if (v.view === 'maps') {
    paintPicture(other, chosenMap(v).picture, chosenMap(v).white / gain);
  } else if (v.view === 'difference') {
    const way = control(v, 'signed').checked ? paintSigned : paintAbsolute;
    way(other, v.a.picture, v.b.picture, v.a.white / (v.gain * gain));
  } else {
    const exposure = 2 ** number(v, 'exposure');
    paintPicture(a, v.a.picture, v.a.white / exposure);
    paintPicture(b, v.b.picture, v.b.white / exposure);
  }
  label(v);
  draw(v);
}

// ---- What is said

function label(v) {
  const gain = 2 ** number(v, 'gain'), stops = number(v, 'exposure');
  const said = {
    split: `${Math.round(number(v, 'split'))} %`, rate: `${number(v, 'rate')} changes per second`,
    exposure: `${stops > 0 ? '+' : ''}${stops} stops, white = ${short(v.a.white / 2 ** stops)} ${v.unit}`,
    gain: v.view === 'maps' ? `white = ${short(chosenMap(v).white / gain)}` :
        `\u00d7${short(v.gain * gain)}`};
  for (const [name, text] of Object.entries(said)) {
    control(v, name).setAttribute('aria-valuetext', text);
    control(v, name).nextElementSibling.textContent = text;
  }
  const one = {flicker: (v.swapped ? v.b : v.a).title, maps: v.maps.length && chosenMap(v).title,
    difference: `${v.a.title} \u2212 ${v.b.title}`}[v.view] || v.a.title;
  const tags = [one, v.view === 'slider' ? v.b.title : '', v.b.title];
  v.root.querySelectorAll('.tag').forEach((tag, k) => { tag.textContent = tags[k]; });
  v.canvases[0].setAttribute('aria-label', tags[1] ? `${one} | ${tags[1]}` : one);
  v.canvases[1].setAttribute('aria-label', v.b.title);
  v.stages.forEach(stage => stage.setAttribute('aria-label', `${views[v.view]}, keys move and zoom`));
}

// The values of the pixel at (x, y) of the stage.
function read(v, x, y) {
  const {scale, left, top} = place(v);
  const column = Math.floor((x - left) / scale), row = Math.floor((y - top) / scale);
  if (column < 0 || row < 0 || column >= v.width || row >= v.height) return;
  const texts = [v.a, v.b, ...(v.view === 'maps' ? [chosenMap(v)] : [])].map(layer => {
    const values = layer.picture.planes.map(
        (_, c) => short(valueAt(layer.picture, row * v.width + column, c)));
    return `${layer.title} ${values.join(' ')} ${layer.unit}`;
  });
  v.root.querySelector('.readout').textContent = `x ${column}, y ${row}: ${texts.join('; ')}`;
}

// ---- What is done

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
