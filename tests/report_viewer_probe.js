// Put at the end of a report's page by report_viewer_test.cpp: uses the first viewer as a person
// would, and leaves what was seen as JSON in <pre id="seen">.
'use strict';

const pause = ms => new Promise(done => setTimeout(done, ms));

async function waitFor(condition) {
  for (let i = 0; i < 300 && !condition(); ++i) await pause(20);
}

function pickView(viewer, view) {
  viewer.querySelector(`.modes [value=${view}]`).click();
}

function setControl(viewer, name, value) {
  const input = viewer.querySelector(`[name=${name}]`);
  if (input.type === 'checkbox') input.checked = value;
  else input.value = value;
  input.dispatchEvent(new Event('input', {bubbles: true}));
}

function press(viewer, name) {
  viewer.querySelector(`button[name=${name}]`).click();
}

// A copy that is read from memory: chromium complains of canvases that are read more than once.
function copyOf(canvas) {
  const copy = document.createElement('canvas').getContext('2d', {willReadFrequently: true});
  copy.canvas.width = canvas.width;
  copy.canvas.height = canvas.height;
  copy.drawImage(canvas, 0, 0);
  return copy;
}

// Bytes of the canvas at shares of its width and height.
function pixelsOf(canvas, places) {
  const copy = copyOf(canvas), {width, height} = canvas;
  return places.map(([across, down]) => [...copy.getImageData(
      Math.floor(across * width), Math.floor(down * height), 1, 1).data].slice(0, 3));
}

// The bytes in the middles of width x height pixels that fill the canvas.
function gridOf(canvas, width, height) {
  return pixelsOf(canvas, [...Array(width * height).keys()].map(
      i => [(i % width + 0.5) / width, (Math.floor(i / width) + 0.5) / height]));
}

function still(article, k) {
  const image = article.querySelectorAll('.stills img')[k];
  const canvas = document.createElement('canvas');
  canvas.width = image.naturalWidth;
  canvas.height = image.naturalHeight;
  canvas.getContext('2d', {willReadFrequently: true}).drawImage(image, 0, 0);
  return gridOf(canvas, image.naturalWidth, image.naturalHeight);
}

function pointer(stage, type, across, down, id = 1) {
  const box = stage.getBoundingClientRect();
  stage.dispatchEvent(new PointerEvent(type, {bubbles: true, pointerId: id,
    clientX: box.left + across * box.width, clientY: box.top + down * box.height}));
}

function readoutAt(viewer, stage, across, down) {
  pointer(stage, 'pointermove', across, down, 99);
  return viewer.querySelector('.readout').textContent;
}

const key = (stage, name) =>
    stage.dispatchEvent(new KeyboardEvent('keydown', {key: name, bubbles: true, cancelable: true}));

const wheel = (stage, deltaY, ctrlKey) => stage.dispatchEvent(new WheelEvent('wheel', {deltaY, ctrlKey,
  bubbles: true, cancelable: true, clientX: stage.getBoundingClientRect().left + 1,
  clientY: stage.getBoundingClientRect().top + 1}));

// Names of what can be used and has no label.
function unnamed(root) {
  return [...root.querySelectorAll('input, select, button, canvas, .stage')].filter(element => {
    const label = element.closest('label');
    const text = element.getAttribute('aria-label') || (label || element).textContent;
    return !text.trim();
  }).map(element => element.outerHTML);
}

async function useViewer(article) {
  const viewer = article.querySelector('.viewer'), stages = [...viewer.querySelectorAll('.stage')];
  const canvases = stages.map(stage => stage.querySelector('canvas'));
  const {width, height} = document.getElementById('packed-0').dataset, seen = {};
  const grid = k => gridOf(canvases[k], Number(width), Number(height));
  const tag = () => viewer.querySelector('.tag').textContent;
  const atEnds = () => pixelsOf(canvases[0], [[0.3, 0.1], [0.7, 0.1]]);

  seen.unnamed = unnamed(viewer);
  seen.stillsHidden = getComputedStyle(article.querySelector('.stills')).display;
  setControl(viewer, 'split', 90);
  seen.slider90 = atEnds();
  setControl(viewer, 'split', 10);
  seen.slider10 = atEnds();
  pointer(stages[0], 'pointerdown', 0.5, 0.5);
  pointer(stages[0], 'pointermove', 0.8, 0.5);
  pointer(stages[0], 'pointerup', 0.8, 0.5);
  pointer(stages[0], 'pointermove', 0.1, 0.5);  // no longer held
  seen.sliderDragged = viewer.querySelector('[name=split]').value;
  key(stages[0], 'ArrowLeft');
  seen.sliderKey = viewer.querySelector('[name=split]').value;

  pickView(viewer, 'sides');
  seen.stills = [0, 1, 2, 3].map(k => still(article, k));
  seen.sides = [grid(0), grid(1)];
  setControl(viewer, 'exposure', 2);
  seen.brighter = grid(0);
  setControl(viewer, 'exposure', -3);
  seen.darker = grid(0);
  setControl(viewer, 'exposure', 0);
  seen.readout = readoutAt(viewer, stages[0], 0.5 / width, 0.5 / height);

  press(viewer, 'in');
  press(viewer, 'in');
  pointer(stages[1], 'pointerdown', 0.5, 0.5);
  pointer(stages[1], 'pointermove', 0.4, 0.45);
  pointer(stages[1], 'pointerup', 0.4, 0.45);
  seen.inStep = [0.2, 0.5, 0.9].map(share => stages.map(
      stage => readoutAt(viewer, stage, share, share).split(':')[0]));
  const across = pixelsOf(canvases[0], [...Array(512).keys()].map(i => [(i + 0.5) / 512, 0.5]));
  seen.squaresAcross = across.filter((color, i) => i === 0 || String(color) !== String(across[i - 1])).length;
  press(viewer, 'fit');
  seen.fitted = grid(1);
  wheel(stages[0], -400, false);
  seen.wheelPassing = readoutAt(viewer, stages[0], 0.99, 0.01).split(',')[0];
  wheel(stages[0], -400, true);
  seen.wheelHeld = readoutAt(viewer, stages[0], 0.99, 0.01).split(',')[0];
  press(viewer, 'fit');
  pointer(stages[0], 'pointerdown', 0.45, 0.5, 1);
  pointer(stages[0], 'pointerdown', 0.55, 0.5, 2);
  pointer(stages[0], 'pointermove', 0.95, 0.5, 2);
  pointer(stages[0], 'pointerup', 0.95, 0.5, 2);
  pointer(stages[0], 'pointerup', 0.45, 0.5, 1);
  seen.pinched = readoutAt(viewer, stages[0], 0.99, 0.5).split(',')[0];
  key(stages[0], '0');
  seen.keyFits = readoutAt(viewer, stages[0], 0.99, 0.5).split(',')[0];

  pickView(viewer, 'flicker');
  await pause(2000);
  seen.flickerStill = tag();
  press(viewer, 'swap');
  seen.flickerSwapped = [tag(), grid(0)];
  press(viewer, 'swap');
  setControl(viewer, 'rate', 6);
  press(viewer, 'play');
  await waitFor(() => tag() !== seen.flickerStill);
  seen.flickerPlayed = tag();
  press(viewer, 'play');
  seen.flickerPressed = viewer.querySelector('[name=play]').getAttribute('aria-pressed');

  pickView(viewer, 'difference');
  seen.signed = grid(0);
  setControl(viewer, 'signed', false);
  seen.absolute = grid(0);
  setControl(viewer, 'gain', -3);
  seen.absoluteLess = grid(0);
  press(viewer, 'reset');
  seen.reset = grid(0);
  pickView(viewer, 'maps');
  seen.map = grid(0);
  return seen;
}

addEventListener('load', async () => {
  const articles = [...document.querySelectorAll('.comparison')];
  await waitFor(() => articles.every(article => article.dataset.state === 'ready'));
  const out = document.createElement('pre');
  try {
    out.textContent = JSON.stringify(await useViewer(articles[0]));
  } catch (error) {
    console.error(error.stack);
  }
  out.id = 'seen';
  document.body.append(out);
});
