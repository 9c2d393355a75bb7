// The page: one situation, which pictures show and change, and the engine answers.
"use strict";
import { Stream, ask } from "./engine.js";
import { Fields } from "./fields.js";
import { paint, readExtended, readMap } from "./hands.js";
import { fromFragment, newBody, reachOf, toFragment, viewOf } from "./model.js";
import { Plans, Strata } from "./plans.js";
import { Scene } from "./scene.js";

const INSTANTS = 48, CHUNK = 8; // of a film, and of a question
const SLOWNESS = 0.45; // of a film to real time
const MOST_PAST = 200; // situations that can be undone
const HOLD = 1.2; // [s] at the end of a film
const GOAL = 85; // [ms] for an answer while something is dragged
const DEADLINES = [0.01, 0.04], LAZY = 3; // [s] of plans, and answers for each map, where answers are slow
const STARTING = "The engine is starting. The first time it compiles for this machine, which may take a minute.";
const WORKING = "The engine is still working. The first answer of a planner compiles it, which may take a minute.";
const byId = (id) => document.getElementById(id);

const state = { situation: null, view: 2.2, t: 0, chosen: 0, plans: [] };
let maps = [], film = new Map(), moving = false, playing = 0, looped = false, aged = true, drawn = 0;
let started = false, slow = false, deadline = DEADLINES[1], count = 0;

const scenes = [
  new Scene(document.querySelector("#workspace svg"), { hands: false, changed, choose }),
  ...[0, 1].map((k) => new Scene(document.querySelector(`#hands-${k} svg`), { hands: true, changed, choose })),
];
scenes[2].svg.classList.add("second-hands");
const painted = new Map(); // what each canvas shows
const canvases = [0, 1].map((k) => document.querySelector(`#hands-${k} canvas`));
const fields = new Fields(byId("bodies"), byId("fields"), { choose, changed });
const plans = new Plans(byId("plans"), () => { compare(); answers.want(); });
const strata = new Strata(byId("letters"), byId("reasons"));

// --- the engine -------------------------------------------------------------------------------
const answers = new Stream("answer", () => ({
  situation: state.situation, planners: plans.names(), instants: [state.t],
  map: byId("map").checked && !(hurried() && (count += 1) % LAZY), ...(hurried() ? { deadline } : {}),
}), useAnswer, { fail: failed, late });
const filming = new Stream("extend", () => ({ situation: state.situation, instants: missing().slice(0, CHUNK) }), useFilm, { fail: failed, late });
function late(yes) { if (started) say(yes ? WORKING : ""); }

const hurried = () => moving && slow;

function useAnswer(answer, question, took) {
  if (!started) say("");
  started = true;
  problem(answer.error);
  if (answer.error) return;
  slow = took > GOAL || (slow && moving);
  deadline = slow ? Math.min(DEADLINES[1], Math.max(DEADLINES[0], (deadline * GOAL) / took)) : DEADLINES[1];
  state.plans = answer.plans;
  maps = answer.plans.map((plan, k) => (plan.map ? readMap(plan.map) : question.map ? null : maps[k]));
  film = new Map(answer.extended.map((e) => [e.time, readExtended(e)]));
  plans.show(state.plans, byId("verdict"));
  speed(answer.parts_ms, took);
  draw();
  if (!moving && !answers.wanted) fillFilm();
}

function useFilm(answer, question) {
  if (answer.error || JSON.stringify(question.situation) !== JSON.stringify(state.situation)) return;
  for (const picture of answer.extended) film.set(picture.time, readExtended(picture));
  fillFilm();
  if (!playing) draw();
}

const missing = () => Array.from({ length: INSTANTS + 1 }, (_, k) => (k / INSTANTS) * state.situation.horizon).filter((t) => !film.has(t));
const fillFilm = () => { if (missing().length && !moving) filming.want(); };
function failed(error) { problem(error instanceof TypeError ? "The engine has ended; start gcm-learn play again." : error.message); }

function problem(text) {
  byId("problem").hidden = !text;
  byId("problem").textContent = text ?? "";
  document.body.classList.toggle("stale", Boolean(text));
}

function speed(parts, took) {
  const inside = Object.entries(parts).map(([name, ms]) => `${name} ${ms.toFixed(1)}`).join(", ");
  byId("speed").textContent = `Answer in ${took.toFixed(0)} ms (${inside})`;
}

// --- changes ----------------------------------------------------------------------------------
function changed(phase) {
  moving = phase === "moving";
  if (moving) stop();
  if (!moving) { state.view = viewOf(state.situation); remember(); }
  if (!aged) strata.age();
  aged = true;
  answers.want();
  draw();
}

// Situations as texts: those before this one, those undone, and this one.
const past = [], undone = [];
let present = null;

function remember() {
  const text = JSON.stringify(state.situation);
  if (text !== present) {
    if (present !== null && past.push(present) > MOST_PAST) past.shift();
    undone.length = 0;
    present = text;
  }
  byId("undo").disabled = !past.length;
  byId("redo").disabled = !undone.length;
}

function turn(from, to) {
  if (!from.length || moving) return;
  to.push(present);
  present = from.pop();
  state.situation = JSON.parse(present);
  state.chosen = Math.min(state.chosen, state.situation.bodies.length - 1);
  changed("moved");
}

byId("undo").onclick = () => turn(past, undone);
byId("redo").onclick = () => turn(undone, past);

function choose(index) {
  state.chosen = index;
  draw();
}

function take(situation) {
  Object.assign(state, { situation, chosen: situation.bodies.findIndex((b) => b.role === "target"), plans: [], t: 0 });
  for (const body of situation.bodies) {
    body.motion = { velocity: [0, 0], acceleration: [0, 0], angle: 0, spin: 0, ...body.motion };
  }
  [maps, film] = [[], new Map()];
  slider.value = 0;
  changed("moved");
}

async function open(kind, question) {
  if (kind === "draw") say("Drawing …");
  try {
    const found = await ask(kind, question);
    if (started) say("");
    if (found.error) note(found.error);
    else if (found.situation) take(found.situation);
  } catch (error) { failed(error); }
}

// --- pictures ---------------------------------------------------------------------------------
// Pictures are drawn once a frame, however often things change in between.
function draw() { drawn ||= requestAnimationFrame(drawNow); }

function drawNow() {
  drawn = 0;
  if (!state.situation) return;
  scenes.forEach((scene, k) => { if (k < 2 || comparing()) scene.draw(k ? { ...state, plans: k > 1 ? [state.plans[1]] : [state.plans[0]] } : state); });
  canvases.forEach((canvas, k) => { if (!k || comparing()) picture(canvas, maps[k]); });
  fields.draw(state.situation, state.chosen);
  byId("now").textContent = `${state.t.toFixed(2)} s`;
  ticks();
}

function picture(canvas, map) {
  const arm = state.situation.arm, reach = reachOf(arm);
  const size = Math.round(canvas.clientWidth * Math.min(2, devicePixelRatio || 1)) || 320;
  let nearest = null;
  for (const frame of film.values()) if (!nearest || Math.abs(frame.time - state.t) < Math.abs(nearest.time - state.t)) nearest = frame;
  const shown = {
    map: byId("map").checked ? map : null, extended: nearest, t: state.t, speed: arm.max_hand_speed,
    inner: Math.abs(reach - 2) / reach, share: reach / state.view, size,
  };
  const before = painted.get(canvas);
  if (before && Object.keys(shown).every((name) => shown[name] === before[name])) return;
  painted.set(canvas, shown);
  if (canvas.width !== size) canvas.width = canvas.height = size;
  paint(canvas, shown);
}

function ticks() {
  const marks = state.plans.map((plan, k) => [plan.catch_time, k]).filter(([t]) => typeof t === "number");
  byId("ticks").replaceChildren(...marks.map(([t, k]) => {
    const mark = Object.assign(document.createElement("span"), { className: k ? "other" : "", title: `caught at ${t.toFixed(3)} s` });
    mark.style.left = `calc(${(100 * t) / state.situation.horizon}% + ${8 - (16 * t) / state.situation.horizon}px)`;
    return mark;
  }));
}

const comparing = () => plans.names().length > 1;
function compare() {
  document.body.classList.toggle("compare", comparing());
  byId("hands-1").hidden = !comparing();
  plans.names().forEach((name, k) => { document.querySelector(`#hands-${k} b`).textContent = comparing() ? ` of ${name}` : ""; });
}

// --- time -------------------------------------------------------------------------------------
const slider = byId("time"), button = byId("play");
const end = () => Math.max(0, ...state.plans.map((p) => p.catch_time ?? 0)) || state.situation.horizon;

function at(t) {
  state.t = t;
  slider.value = Math.round((1000 * t) / state.situation.horizon);
  draw();
}

function play(once = false) {
  looped = !once;
  const began = performance.now() - (state.t < end() ? state.t / SLOWNESS : 0) * 1000;
  button.textContent = "❚❚ Pause";
  button.setAttribute("aria-label", "Pause the film");
  const step = () => {
    const t = (SLOWNESS * (performance.now() - began)) / 1000;
    at(Math.min(t, end()));
    if (t < end() + SLOWNESS * HOLD) playing = requestAnimationFrame(step);
    else if (looped) { state.t = 0; play(); } else { stop(); at(0); }
  };
  playing = requestAnimationFrame(step);
}

function stop() {
  cancelAnimationFrame(playing);
  playing = 0;
  button.textContent = "▶ Play";
  button.setAttribute("aria-label", "Play the film");
}

slider.oninput = () => { stop(); at((slider.value / 1000) * state.situation.horizon); };
button.onclick = () => (playing ? stop() : play());
byId("map").onchange = () => answers.want();
addEventListener("resize", () => draw());

addEventListener("keydown", (event) => {
  const inField = /^(INPUT|SELECT|BUTTON|TEXTAREA)$/.test(event.target.tagName);
  if ((event.ctrlKey || event.metaKey) && /^[zy]$/i.test(event.key) && !event.target.matches("input[type=number]")) {
    event.preventDefault();
    byId(event.shiftKey || /y/i.test(event.key) ? "redo" : "undo").click();
  }
  if (event.key === " " && !inField) { event.preventDefault(); button.click(); }
  if ((event.key === "Delete" || event.key === "Backspace") && !inField && event.target.closest("[data-index]")) byId("remove").click();
});

// --- situations: drawn, loaded, saved, shared ---------------------------------------------------
function note(text) {
  say(text);
  setTimeout(() => { if (byId("note").textContent === text) say(""); }, 3500);
}
function say(text) { byId("note").textContent = text; }

const family = byId("family"), index = byId("index");
const redraw = () => open("draw", { name: family.value, index: Number(index.value) || 0 });
family.onchange = () => { byId("numbered").hidden = byId("next").hidden = family.selectedOptions[0]?.dataset.numbered !== "yes"; if (family.value) redraw(); };
index.onchange = redraw;
byId("next").onclick = () => { index.value = (Number(index.value) || 0) + 1; redraw(); };
byId("source").onsubmit = (event) => event.preventDefault();

byId("save").onclick = () => {
  const text = JSON.stringify(state.situation, null, 1), link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob([text + "\n"], { type: "application/json" }));
  link.download = `${state.situation.name.replace(/[^\w.-]+/g, "_") || "situation"}.json`;
  link.click();
  URL.revokeObjectURL(link.href);
};
byId("load").onclick = () => byId("file").click();
byId("file").onchange = async () => {
  const [file] = byId("file").files;
  byId("file").value = "";
  if (file) await open("read", { text: await file.text() });
};
addEventListener("dragover", (event) => event.preventDefault());
addEventListener("drop", async (event) => {
  event.preventDefault();
  if (event.dataTransfer.files[0]) await open("read", { text: await event.dataTransfer.files[0].text() });
});
byId("share").onclick = async () => {
  history.replaceState(null, "", "#" + toFragment(state.situation));
  try { await navigator.clipboard.writeText(location.href); note("Copied: the part from # on holds the situation"); } catch { note("The address now holds the situation: copy it"); }
};
addEventListener("hashchange", () => openFragment());

async function openFragment() {
  let text = null;
  try { text = fromFragment(location.hash); } catch { note("The address holds no situation that can be read"); }
  if (text !== null) await open("read", { text });
}

// --- bodies and strata --------------------------------------------------------------------------
for (const kind of ["disc", "bar"]) {
  byId(`add-${kind}`).onclick = () => {
    state.situation.bodies.push(newBody(state.situation, kind));
    state.chosen = state.situation.bodies.length - 1;
    changed("moved");
  };
}
byId("remove").onclick = () => {
  if (state.chosen < 0) return;
  state.situation.bodies.splice(state.chosen, 1);
  state.chosen = Math.min(state.chosen, state.situation.bodies.length - 1);
  changed("moved");
};
byId("explain").onclick = async () => {
  byId("explain").disabled = true;
  byId("explain").textContent = "Looking for all ways …";
  try {
    const asked = JSON.stringify(state.situation), found = await ask("explain", { situation: state.situation });
    if (!found.dropped && asked === JSON.stringify(state.situation)) { strata.show(found); aged = false; }
  } catch (error) { failed(error); }
  byId("explain").disabled = false;
  byId("explain").textContent = "Explain this situation";
};

// --- the beginning ------------------------------------------------------------------------------
function offer(offered) {
  const group = (label, names, numbered) => {
    const found = Object.assign(document.createElement("optgroup"), { label });
    found.append(...names.map((name) => Object.assign(new Option(name), { value: name })));
    for (const option of found.children) option.dataset.numbered = numbered;
    return found;
  };
  const own = new Option("this one", "");
  family.replaceChildren(own, group("scenes", offered.scenes, "no"), group("families", offered.families, "yes"));
  plans.offer(offered.planners, plans.names());
  plans.show(state.plans, byId("verdict"));
}

// The scene is there at once; the first plan comes when the engine is ready, and the lists after it.
async function begin() {
  say(STARTING);
  plans.offer(["search"], ["search"]);
  take(await (await fetch("given.json")).json());
  ask("begin").then(offer, failed);
  await openFragment();
  if (!started) say(STARTING);
  const waiting = setInterval(() => {
    if (!state.plans.length) return;
    clearInterval(waiting);
    if (state.t === 0 && !moving && !matchMedia("(prefers-reduced-motion: reduce)").matches) play(true);
  }, 150);
}
begin().catch(failed);
