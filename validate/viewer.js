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
