"use strict";
const D = JSON.parse(document.getElementById("data").textContent), U = 1000;
const $ = id => document.getElementById(id), C = D.colours;
const PALETTE = ["#2b6cb0", "#dd6b20", "#2f855a", "#b83280", "#b7791f", "#319795", "#6b46c1",
  "#c53030", "#718096", "#68d391", "#f6ad55", "#63b3ed", "#d53f8c", "#4a5568", "#9ae6b4",
  "#fbd38d", "#a3bffa", "#feb2b2", "#81e6d9", "#000000"];
let by = Object.keys(D.points[0].words)[0], only = null, shown = 0, began = 0;
const images = new Map();

function classes() {
  const n = {};
  for (const p of D.points) n[p.words[by]] = (n[p.words[by]] || 0) + 1;
  return Object.keys(n).sort((a, b) => n[b] - n[a] || (a < b ? -1 : 1)).map(w => [w, n[w]]);
}
function colourOf(word, names) {
  const k = names.indexOf(word);
  return k < PALETTE.length - 1 ? PALETTE[k] : PALETTE[PALETTE.length - 1];
}
function place(p) { return [40 + 1040 * p.at[0] / U, 1000 - 960 * p.at[1] / U]; }

function drawPoints() {
  const g = $("points").getContext("2d"), names = classes().map(c => c[0]);
  g.clearRect(0, 0, 1120, 1040);
  for (const p of D.points) {
    const [x, y] = place(p), quiet = only !== null && p.words[by] !== only;
    g.globalAlpha = quiet ? 0.08 : 0.8;
    g.fillStyle = colourOf(p.words[by], names);
    g.beginPath(); g.arc(x, y, 7, 0, 7); g.fill();
  }
  g.globalAlpha = 1;
  const [x, y] = place(D.points[shown]);
  g.lineWidth = 4; g.strokeStyle = "#000"; g.beginPath(); g.arc(x, y, 12, 0, 7); g.stroke();
}
function drawLegend() {
  const all = classes(), names = all.map(c => c[0]);
  $("legend").replaceChildren(...all.slice(0, 24).map(([word, n]) => {
    const span = document.createElement("span"), dot = document.createElement("i");
    dot.style.background = colourOf(word, names);
    span.append(dot, `${word} (${n})`);
    if (only === word) span.style.fontWeight = "bold";
    span.onclick = () => { only = only === word ? null : word; drawLegend(); drawPoints(); };
    return span;
  }));
}
function lerp(list, width, t, times) {
  let k = 0;
  while (k < times.length - 2 && times[k + 1] < t) k++;
  const span = times[k + 1] - times[k];
  const s = span > 0 ? Math.min(Math.max((t - times[k]) / span, 0), 1) : 1, out = [];
  for (let j = 0; j < width; j++)
    out.push(list[k * width + j] * (1 - s) + list[(k + 1) * width + j] * s);
  return out;
}
function frames(m) {
  const n = m.bodies.length ? (m.bodies[0].cuts ? m.bodies[0].cuts.length
    : m.bodies[0].at.length / 2) : 2;
  return Array.from({length: n}, (_, k) => m.end * k / (n - 1));
}
function view(g, m) {
  const reach = m.arm + U, s = 274 / (1.06 * reach);
  g.setTransform(1, 0, 0, 1, 0, 0); g.clearRect(0, 0, 548, 548);
  g.setTransform(s, 0, 0, -s, 274, 274);
  g.lineWidth = 2 / s; g.strokeStyle = C.faint; g.setLineDash([8 / s, 6 / s]);
  for (const r of [reach, Math.abs(m.arm - U)]) { g.beginPath(); g.arc(0, 0, r, 0, 7); g.stroke(); }
  g.setLineDash([]);
  return s;
}
function line(g, points, colour, width) {
  g.strokeStyle = colour; g.lineWidth = width;
  g.lineJoin = g.lineCap = "round"; g.beginPath();
  for (let k = 0; k < points.length; k += 2) g.lineTo(points[k], points[k + 1]);
  g.stroke();
}
function body(g, b, t, times, alpha) {
  g.fillStyle = b.target ? C.target : C.obstacle; g.globalAlpha = alpha; g.beginPath();
  if (b.cuts) {
    let k = 0;
    times.forEach((u, j) => { if (Math.abs(u - t) < Math.abs(times[k] - t)) k = j; });
    for (let j = 0; j < b.cuts[k].length; j += 2) g.lineTo(b.cuts[k][j], b.cuts[k][j + 1]);
  } else {
    const [x, y] = lerp(b.at, 2, t, times);
    if (b.radius) g.arc(x, y, b.radius, 0, 7);
    else {
      const a = lerp(b.turn, 1, t, times)[0] / U, c = Math.cos(a), s = Math.sin(a);
      for (let j = 0; j < b.shape.length; j += 2) {
        const px = b.shape[j], py = b.shape[j + 1];
        g.lineTo(x + c * px - s * py, y + s * px + c * py);
      }
    }
  }
  g.closePath(); g.fill(); g.globalAlpha = 1;
}
function limb(g, m, x, y, s) {
  const r = Math.max(Math.hypot(x, y), 1e-6);
  const b = Math.acos(Math.min(Math.max((r * r + m.arm * m.arm - U * U) / (2 * m.arm * r), -1), 1));
  const a = Math.atan2(y, x) - b;
  line(g, [0, 0, m.arm * Math.cos(a), m.arm * Math.sin(a), x, y], C.arm, 9 / s);
  g.fillStyle = C.arm; g.beginPath(); g.arc(x, y, 11 / s, 0, 7); g.fill();
}
function scene(m, now) {
  const g = $("catch").getContext("2d"), s = view(g, m), times = frames(m);
  const hold = 900, t = Math.min(((now - began) * 0.5) % (m.end + hold), m.end);
  for (const b of m.bodies) body(g, b, 0, times, 0.18);
  line(g, m.hand, C.path, 4 / s);
  for (const b of m.bodies) body(g, b, t, times, 1);
  const [x, y] = lerp(m.hand, 2, t, m.time);
  limb(g, m, x, y, s);
}
function chart(canvas, m, wanted) {
  let image = images.get(m);
  if (!image) {
    image = new Image(); images.set(m, image);
    image.src = "data:image/png;base64," + m.map;
  }
  if (!image.complete) image.addEventListener("load", () => chart(canvas, m, wanted));
  if (!image.complete || !wanted()) return;
  const g = canvas.getContext("2d"), s = view(g, m), reach = m.arm + U;
  g.save(); g.beginPath(); g.arc(0, 0, reach, 0, 7); g.clip(); g.scale(1, -1);
  g.drawImage(image, -reach, -reach, 2 * reach, 2 * reach); g.restore();
  line(g, m.hand, C.path, 5 / s);
  g.fillStyle = C.arm; g.beginPath(); g.arc(m.hand[0], m.hand[1], 11 / s, 0, 7); g.fill();
}
function show(k) {
  shown = k; began = performance.now();
  const p = D.points[k], w = Object.entries(p.words).map(([a, b]) => `${a}: ${b}`).join(", ");
  $("catch-words").textContent = `caught after ${(p.end / 1000).toFixed(2)} s`;
  $("map-words").textContent = w;
  drawPoints(); chart($("map"), p, () => p === D.points[shown]);
}
function nearest(event) {
  const box = $("points").getBoundingClientRect(), f = 1120 / box.width;
  const x = (event.clientX - box.left) * f, y = (event.clientY - box.top) * f;
  let best = -1, near = 40 * 40;
  D.points.forEach((p, k) => {
    if (only !== null && p.words[by] !== only) return;
    const [a, b] = place(p), d = (a - x) ** 2 + (b - y) ** 2;
    if (d < near) { near = d; best = k; }
  });
  return best;
}
$("points").onmousemove = $("points").onclick = event => {
  const k = nearest(event);
  if (k >= 0 && k !== shown) show(k);
};
for (const name of Object.keys(D.points[0].words)) $("by").append(new Option(name, name));
$("by").onchange = () => { by = $("by").value; only = null; drawLegend(); drawPoints(); };
drawLegend(); show(0);
for (const card of document.querySelectorAll("[data-point]")) {
  const k = Number(card.dataset.point), p = D.points[k], names = classes().map(c => c[0]);
  card.querySelector("i").style.background = colourOf(p.words[by], names);
  chart(card.querySelector("canvas"), p, () => true);
  card.querySelector("a").onclick = () => {
    by = $("by").value = Object.keys(p.words)[0]; only = p.words[by]; drawLegend(); show(k);
  };
}
function tick(now) {
  scene(D.points[shown], now);
  requestAnimationFrame(tick);
}
requestAnimationFrame(tick);
