// The page's pictures: unpacked, read, and painted on a canvas.
'use strict';

// The value of every half float by its bits; NaN for those that are no finite number.
const halfValues = new Float32Array(65536).map((_, bits) => {
  const exponent = bits >> 10 & 31, mantissa = bits & 1023;
  if (exponent === 31) return NaN;
  const size = exponent ? (1024 + mantissa) * 2 ** (exponent - 25) : mantissa * 2 ** -24;
  return bits >> 15 ? -size : size;
});

// The inverse of pack_picture (validate/report_parts.h).
async function unpack(element) {
  const [width, height, channels] =
      ['width', 'height', 'channels'].map(key => Number(element.dataset[key]));
  const packed = Uint8Array.from(atob(element.textContent), letter => letter.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream('deflate'));
  const bytes = new Uint8Array(await new Response(stream).arrayBuffer());
  const count = width * height, planes = [];
  for (let c = 0; c < channels; ++c) {
    const plane = new Uint16Array(count), begin = 2 * count * c;
    for (let i = 0; i < count; ++i) {
      const step = bytes[begin + i] << 8 | bytes[begin + count + i];
      plane[i] = (i % width ? plane[i - 1] : 0) + step;  // modulo 2^16, by its type
    }
    planes.push(plane);
  }
  return {width, height, planes, scale: 2 ** element.dataset.exponent};
}

// One channel serves for red, green and blue.
const planeOf = (picture, c) => picture.planes[picture.planes.length === 1 ? 0 : c];
const valueAt = (picture, i, c) => halfValues[planeOf(picture, c)[i]] * picture.scale;

// Rec.709 (atlas/rec709.h).
const luminanceAt = (picture, i) => 0.2126 * valueAt(picture, i, 0) +
    0.7152 * valueAt(picture, i, 1) + 0.0722 * valueAt(picture, i, 2);

// The byte that a PNG has (atlas/image_io.h): sRGB, cut to 0 .. 1, rounded; NaN stays.
function screenByte(linear) {
  const v = Math.min(Math.max(linear, 0), 1);
  return Math.round(255 * (v <= 0.0031308 ? 12.92 * v : 1.055 * v ** (1 / 2.4) - 0.055));
}

// Bytes of pixel i, by channel, from `byteAt(i, c)`; magenta where one is NaN.
function paint(canvas, {width, height}, byteAt) {
  canvas.width = width;
  canvas.height = height;
  const image = new ImageData(width, height), bytes = image.data;
  for (let i = 0; i < width * height; ++i) {
    const red = byteAt(i, 0), green = byteAt(i, 1), blue = byteAt(i, 2);
    const broken = Number.isNaN(red + green + blue);
    bytes[4 * i] = broken ? 255 : red;
    bytes[4 * i + 1] = broken ? 0 : green;
    bytes[4 * i + 2] = broken ? 255 : blue;
    bytes[4 * i + 3] = 255;
  }
  canvas.getContext('2d').putImageData(image, 0, 0);
}

// As a PNG with this white.
function paintPicture(canvas, picture, white) {
  const table = Array.from(halfValues, half => screenByte(half * picture.scale / white));
  paint(canvas, picture, (i, c) => table[planeOf(picture, c)[i]]);
}

// Of luminance: red where a is more, blue where it is less.
function paintSigned(canvas, a, b, white) {
  const signs = [1, 0, -1];
  paint(canvas, a, (i, c) => screenByte(signs[c] * (luminanceAt(a, i) - luminanceAt(b, i)) / white));
}

// Channel by channel.
function paintAbsolute(canvas, a, b, white) {
  paint(canvas, a, (i, c) => screenByte(Math.abs(valueAt(a, i, c) - valueAt(b, i, c)) / white));
}
