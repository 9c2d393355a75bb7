// Hand-space as pixels: the map up to now, the front, and what obstacles forbid.
"use strict";

const SIDE = 200, LEVELS = 250, OBSTACLE = 253, BANDS = 14;
const RAMP = ["#f3f9fb", "#d5e8ee", "#a3cdd6", "#6aa9b8", "#3d7f93"].map(rgb);
const EXTENDED = rgb("#f6ad55"), EFFECTIVE = rgb("#c53030"), FRONT = rgb("#2c5f8f");

function rgb(text) { return [1, 3, 5].map((k) => parseInt(text.slice(k, k + 2), 16)); }

function bytesOf(text) { return Uint8Array.from(atob(text), (c) => c.charCodeAt(0)); }

// Colour of an arrival, in bands as on a map of heights.
const COLOURS = Array.from({ length: LEVELS + 1 }, (_, level) => {
  const share = Math.floor((level / LEVELS) * BANDS) / BANDS * (RAMP.length - 1);
  const k = Math.min(Math.floor(share), RAMP.length - 2);
  return RAMP[k].map((c, i) => c + (share - k) * (RAMP[k + 1][i] - c));
});

// Cells as values at pixels, linear between the centres of those cells that have a value.
// Pixels of which less than half is covered by such cells have none (NaN).
function spread(cells, size, value) {
  const out = new Float32Array(SIDE * SIDE), values = Float32Array.from({ length: size * size }, (_, k) => value(cells, k));
  const scale = size / SIDE, most = size - 2;
  for (let row = 0; row < SIDE; row++) {
    const y = (SIDE - 1 - row + 0.5) * scale - 0.5, y0 = Math.max(0, Math.min(most, Math.floor(y))), v = y - y0;
    for (let column = 0; column < SIDE; column++) {
      const x = (column + 0.5) * scale - 0.5, x0 = Math.max(0, Math.min(most, Math.floor(x))), u = x - x0;
      const k = y0 * size + x0;
      let sum = 0, covered = 0;
      for (let corner = 0; corner < 4; corner++) {
        const right = corner & 1, above = corner >> 1, found = values[k + right + above * size];
        if (Number.isNaN(found)) continue;
        const weight = (right ? u : 1 - u) * (above ? v : 1 - v);
        sum += weight * found;
        covered += weight;
      }
      out[row * SIDE + column] = covered > 0.5 ? sum / covered : NaN;
    }
  }
  return out;
}

const arrivalOf = (cells, k) => (cells[k] <= LEVELS ? cells[k] : NaN);
const frozenOf = (cells, k) => (cells[k] === OBSTACLE ? 1 : 0);
const bitOf = (cells, k) => (cells[k >> 3] >> (7 - (k & 7))) & 1;

export function readMap(map) {
  const cells = bytesOf(map.cells);
  return { last: map.last, level: spread(cells, map.size, arrivalOf), frozen: spread(cells, map.size, frozenOf) };
}

export function readExtended(picture) {
  return { time: picture.time, blocked: spread(bytesOf(picture.cells), picture.size, bitOf) };
}

function mix(data, at, colour, share) {
  for (let i = 0; i < 3; i++) data[at + i] += share * (colour[i] - data[at + i]);
}

// Paint a disc of hand-space. `share` is its radius as a share of half the canvas.
export function paint(canvas, { map, extended, t, speed, inner, share }) {
  const image = new ImageData(SIDE, SIDE), data = image.data.fill(255);
  const now = map ? (t / map.last) * LEVELS : 0, edge = map ? (0.02 / speed / map.last) * LEVELS : 0;
  for (let k = 0, at = 0; k < SIDE * SIDE; k++, at += 4) {
    if (map) {
      const level = map.level[k];
      if (level <= LEVELS) {
        mix(data, at, COLOURS[Math.round(level)], level <= now ? 1 : 0.38);
        if (t > 0 && Math.abs(level - now) < edge) mix(data, at, FRONT, 0.9);
      }
      if (map.frozen[k] > 0.5) mix(data, at, EFFECTIVE, 0.62);
    }
    if (extended) {
      const blocked = Math.min(1, Math.max(0, (extended.blocked[k] - 0.35) / 0.3));
      if (blocked > 0) mix(data, at, EXTENDED, 0.8 * blocked);
    }
  }
  const small = paint.small ??= Object.assign(document.createElement("canvas"), { width: SIDE, height: SIDE });
  small.getContext("2d").putImageData(image, 0, 0);
  const context = canvas.getContext("2d"), half = canvas.width / 2, radius = share * half;
  context.clearRect(0, 0, canvas.width, canvas.height);
  context.save();
  context.beginPath();
  context.arc(half, half, radius, 0, 2 * Math.PI);
  if (inner > 0) context.arc(half, half, inner * radius, 0, 2 * Math.PI, true);
  context.clip();
  context.imageSmoothingQuality = "high";
  context.drawImage(small, half - radius, half - radius, 2 * radius, 2 * radius);
  context.restore();
}
