// The arm and the bodies as rigid solids: each has its corners once, and a pose for every time.
"use strict";
const data = JSON.parse(document.getElementById("data").textContent);
const scene = document.getElementById("scene"), slider = document.getElementById("time");
const play = document.getElementById("play"), now = document.getElementById("now");

// Corners of a solid at time k: columns of x, y and z.
function placed(solid, k) {
  const [px, py, pz] = solid.centre[k], r = solid.turn[k], out = { x: [], y: [], z: [] };
  for (const [a, b, c] of solid.corners) {
    out.x.push(px + r[0] * a + r[1] * b + r[2] * c);
    out.y.push(py + r[3] * a + r[4] * b + r[5] * c);
    out.z.push(pz + r[6] * a + r[7] * b + r[8] * c);
  }
  return out;
}

function mesh(solid) {
  const [i, j, k] = [0, 1, 2].map((m) => solid.triangles.map((t) => t[m]));
  return {
    type: "mesh3d", ...placed(solid, 0), i, j, k, color: solid.colour, name: solid.name,
    flatshading: solid.flat, hoverinfo: "name", opacity: solid.opacity,
    lighting: { ambient: 0.65, diffuse: 0.5, specular: 0.12, roughness: 0.7, fresnel: 0.05 },
    lightposition: { x: 1e4, y: -6e3, z: 2e4 },
  };
}

function line(way) {
  return {
    type: "scatter3d", mode: "lines", x: way.x, y: way.y, z: way.z, name: way.name,
    hoverinfo: "name", line: { width: way.dashed ? 4 : 6, dash: way.dashed ? "dash" : "solid", color: way.colours },
  };
}

const axis = (range) => ({
  range, title: { text: "" }, showspikes: false, gridcolor: "#e2e8f0", zeroline: false,
  backgroundcolor: "#f4f6f9", showbackground: false, tickfont: { size: 10, color: "#a0aec0" },
});
const size = () => ({ width: scene.clientWidth, height: scene.clientHeight });
const layout = {
  ...size(),
  margin: { l: 0, r: 0, t: 0, b: 0 }, showlegend: false, uirevision: "kept",
  scene: {
    xaxis: axis(data.box[0]), yaxis: axis(data.box[1]),
    zaxis: { ...axis(data.box[2]), showbackground: true }, aspectmode: "data",
    camera: { eye: data.eye, center: { x: 0, y: 0, z: 0 } },
  },
};
Plotly.newPlot(scene, [...data.solids.map(mesh), ...data.ways.map(line)], layout,
  { displayModeBar: false });
addEventListener("resize", () => Plotly.relayout(scene, size()));

const all = data.solids.map((_, k) => k);
function show(k) {
  const at = data.solids.map((solid) => placed(solid, k));
  Plotly.restyle(scene, { x: at.map((p) => p.x), y: at.map((p) => p.y), z: at.map((p) => p.z) }, all);
  now.textContent = `t = ${data.times[k].toFixed(2)} s` + (k === data.times.length - 1 ? data.ending : "");
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
slider.value = data.times.length - 1;
show(data.times.length - 1);
