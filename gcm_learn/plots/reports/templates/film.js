// The arm and the bodies as rigid solids: each has its corners once, and a pose for every time.
// In hand-space the arm is a point: its hand, targets and ways stay, effective obstacles come.
"use strict";
const data = JSON.parse(document.getElementById("data").textContent);
const scene = document.getElementById("scene"), slider = document.getElementById("time");
const play = document.getElementById("play"), now = document.getElementById("now");

// A margin has other corners and triangles for small distances than for large ones.
const surfaceOf = (solid, k) => (solid.levels ? solid.levels[solid.level[k]] : solid);

// Corners of a solid at time k: columns of x, y and z.  What is gone shrinks to a point; margins grow.
function placed(solid, k) {
  const [px, py, pz] = solid.centre[k], out = { x: [], y: [], z: [] };
  const r = data.times[k] > solid.until ? Array(9).fill(0) : solid.turn[k];
  const { corners, outward } = surfaceOf(solid, k);
  for (const [m, at] of corners.entries()) {
    const [a, b, c] = outward ? at.map((x, n) => x + solid.wide[k] * outward[m][n]) : at;
    out.x.push(px + r[0] * a + r[1] * b + r[2] * c);
    out.y.push(py + r[3] * a + r[4] * b + r[5] * c);
    out.z.push(pz + r[6] * a + r[7] * b + r[8] * c);
  }
  return out;
}

function sides(triangles) {
  const [i, j, k] = [0, 1, 2].map((m) => triangles.map((t) => t[m]));
  return { i, j, k };
}

const look = {
  type: "mesh3d", hoverinfo: "name",
  lighting: { ambient: 0.65, diffuse: 0.5, specular: 0.12, roughness: 0.7, fresnel: 0.05,
    vertexnormalsepsilon: 0, facenormalsepsilon: 0 },
  lightposition: { x: 1e4, y: -6e3, z: 2e4 },
};

function mesh(solid) {
  return {
    ...look, ...placed(solid, 0), ...sides(surfaceOf(solid, 0).triangles), color: solid.colour, name: solid.name,
    flatshading: solid.flat, opacity: solid.opacity,
  };
}

// The triangles of effective obstacles at time k; without any plotly would make up its own.
function grown(k) {
  return sides(data.hands.counts[k] ? data.hands.triangles.slice(0, data.hands.counts[k]) : [[0, 0, 0]]);
}

function skin(hands) {
  const [x, y, z] = [0, 1, 2].map((m) => hands.corners.map((c) => c[m]));
  return { ...look, x, y, z, ...grown(0), color: hands.colour, name: hands.name, opacity: 0.6, visible: false };
}

function line(way) {
  return {
    type: "scatter3d", mode: "lines", x: way.x, y: way.y, z: way.z, name: way.name,
    hoverinfo: "name", line: way.line,
  };
}

// The catches in their order, with their times, where several are wanted.
function marks(catches) {
  const [x, y, z] = [0, 1, 2].map((m) => catches.map((caught) => caught.place[m]));
  return {
    type: "scatter3d", mode: "markers+text", x, y, z, hoverinfo: "text", textposition: "top center",
    text: catches.map((caught, k) => `${k + 1}: ${caught.name}, ${caught.time.toFixed(2)} s`),
    marker: { size: 5, symbol: "diamond", color: "#2d3748" }, textfont: { size: 13, color: "#2d3748" },
  };
}

const axis = (range) => ({
  range, title: { text: "" }, showspikes: false, gridcolor: "#e2e8f0", zeroline: false,
  backgroundcolor: "#f4f6f9", showbackground: false, tickfont: { size: 10, color: "#a0aec0" },
});
// The eye is farther away where the picture is higher than wide; the box keeps its middle.
const byAxis = (values) => Object.fromEntries(values.map((value, m) => ["xyz"[m], value]));
function aspect(box) {
  const sides = box.map(([a, b]) => b - a), longest = Math.max(...sides);
  return byAxis(sides.map((side) => side / longest));
}
const further = Math.max(1, scene.clientHeight / scene.clientWidth);
const eye = byAxis(["x", "y", "z"].map((m) => further * data.eye[m]));
const larger = (box, f) => box.map(([a, b]) => [(a + b - f * (b - a)) / 2, (a + b + f * (b - a)) / 2]);
const size = () => ({ width: scene.clientWidth, height: scene.clientHeight });
const layout = {
  ...size(),
  margin: { l: 0, r: 0, t: 0, b: 0 }, showlegend: false, uirevision: "kept",
  scene: {
    xaxis: axis(data.box[0]), yaxis: axis(data.box[1]),
    zaxis: { ...axis(data.box[2]), showbackground: true }, aspectmode: "manual",
    aspectratio: aspect(data.box), camera: { eye, center: { x: 0, y: 0, z: 0 } },
  },
};
const surfaces = data.hands ? [skin(data.hands)] : [];
const lines = [...data.ways.map(line), ...(data.catches.length ? [marks(data.catches)] : [])];
Plotly.newPlot(scene, [...data.solids.map(mesh), ...lines, ...surfaces], layout,
  { displayModeBar: false });
addEventListener("resize", () => Plotly.relayout(scene, size()));

const all = data.solids.map((_, k) => k);
const ticked = document.getElementById("hands");
const inHands = () => ticked !== null && ticked.checked;
let framed = 1;
function frame(box, zoom) {
  const [x, y, z] = larger(box, zoom);
  framed = zoom;
  Plotly.relayout(scene, { "scene.xaxis.range": x, "scene.yaxis.range": y, "scene.zaxis.range": z,
    "scene.aspectratio": aspect(box) });
}
function show(k) {
  if (!inHands() && data.zoom[k] !== framed) frame(data.box, data.zoom[k]);
  const at = data.solids.map((solid) => placed(solid, k));
  const parts = data.solids.map((solid) => sides(surfaceOf(solid, k).triangles));
  const of = (things, column) => things.map((thing) => thing[column]);
  Plotly.restyle(scene, { x: of(at, "x"), y: of(at, "y"), z: of(at, "z"),
    i: of(parts, "i"), j: of(parts, "j"), k: of(parts, "k") }, all);
  if (inHands()) {
    const { i, j, k: third } = grown(k);
    Plotly.restyle(scene, { i: [i], j: [j], k: [third] }, [all.length + lines.length]);
  }
  const count = data.catches.filter((caught) => caught.time <= data.times[k] + 1e-4).length;
  const ending = data.held[k] ? `: holds ${data.held[k]}` : k === data.times.length - 1 ? data.ending : "";
  now.textContent = `t = ${data.times[k].toFixed(2)} s` + (data.catches.length ? `: ${count} caught` : ending);
}

let running = null;
function stop() { clearTimeout(running); running = null; play.textContent = "Play"; }
function step() {
  const k = (Number(slider.value) + 1) % data.times.length, last = k === data.times.length - 1;
  slider.value = k; show(k);
  running = setTimeout(step, last ? 1500 : 90);
}
play.onclick = () => { if (running !== null) stop(); else { play.textContent = "Pause"; step(); } };
slider.oninput = () => { stop(); show(Number(slider.value)); };
function change() {
  const on = inHands(), box = on ? data.hands.box : data.box;
  const visible = [...data.solids.map((solid) => !on || solid.hands), ...lines.map(() => true), on];
  Plotly.restyle(scene, { visible });
  frame(box, 1);
  show(Number(slider.value));
}
if (ticked !== null) ticked.onchange = change;
slider.value = 0;
show(0);
