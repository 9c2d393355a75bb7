// A picture that can be dragged: bodies, arms and paths as SVG, in the workspace or in hand-space.
"use strict";
import { boundingRadius, elbowOf, handAt, poseAt, reachOf, setAngle, setPair } from "./model.js";

const AHEAD = 0.25; // [s] of the motion that an arrow shows
const STEP = 0.05, FINE = 0.01, SPEED_STEP = 0.1, TURN_STEP = 0.1;
const KEYS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };

function make(parent, name, attributes = {}) {
  const element = document.createElementNS("http://www.w3.org/2000/svg", name);
  set(element, attributes);
  parent.append(element);
  return element;
}

function set(element, attributes) {
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
}

const line = (points) => points.map(([x, y], k) => `${k ? "L" : "M"}${x.toFixed(4)} ${(-y).toFixed(4)}`).join("");
const place = (pose) => `translate(${pose.x} ${-pose.y}) rotate(${(-pose.angle * 180) / Math.PI})`;

function shapeInto(parent, shape, style) {
  if (shape.kind === "disc") return make(parent, "circle", { r: shape.radius, class: style });
  return make(parent, "path", { d: line(shape.vertices) + "Z", class: style });
}

export class Scene {
  // `changed(phase)` is called while a thing is moved ("moving") and after that ("moved").
  constructor(svg, { hands, changed, choose }) {
    Object.assign(this, { svg, hands, changed, choose, drag: null, parts: [], form: "" });
    svg.classList.toggle("hands", hands);
    svg.addEventListener("pointerdown", (event) => this.press(event));
    svg.addEventListener("pointermove", (event) => this.move(event));
    for (const end of ["pointerup", "pointercancel"]) svg.addEventListener(end, () => this.release());
    svg.addEventListener("keydown", (event) => this.key(event));
    svg.addEventListener("focusin", (event) => {
      const found = event.target.closest("[data-index]");
      if (found && !this.drag) this.choose(Number(found.dataset.index));
    });
  }

  // Elements are made anew only when bodies come, go or change their shape: focus stays.
  build(situation) {
    const form = JSON.stringify(situation.bodies.map((b) => [b.name, b.role, b.shape]));
    if (form === this.form) return;
    this.form = form;
    this.svg.replaceChildren();
    const layer = Object.fromEntries(["ground", "tracks", "starts", "bodies", "ways", "arms", "speeds", "labels"].map((n) => [n, make(this.svg, "g")]));
    this.layer = layer;
    this.rims = [0, 1].map(() => make(layer.ground, "circle", { class: "rim" }));
    this.parts = situation.bodies.map((body, index) => this.buildBody(layer, body, index));
    this.ways = ["way second", "way halo", "way"].map((style) => make(layer.ways, "path", { class: style }));
    this.catches = [1, 0].map(() => make(layer.ways, "circle", { class: "catch" }));
    const arms = [["other ghost"], ["ghost"], ["other"], [""]];
    this.arms = arms.map(([style]) => {
      const group = make(layer.arms, "g", { class: style });
      return { group, bone: make(group, "path", { class: "bone" }), joints: [0, 1].map(() => make(group, "circle", { class: "joint" })) };
    });
    this.begin = make(layer.arms, "circle", { class: "begin" });
    this.hand = make(layer.arms, "g", { class: "body", tabindex: this.hands ? -1 : 0, role: "button", "data-act": "move", "data-index": -1 });
    this.hand.grip = make(this.hand, "circle", { class: "grip" });
    this.hand.dot = make(this.hand, "circle", { class: "hand" });
    this.hand.word = make(layer.labels, "text", { class: "label", "text-anchor": "middle" });
    this.turn = make(layer.speeds, "g", { class: "handle", "data-act": "turn" });
    this.turn.spoke = make(this.turn, "line", { class: "spoke" });
    this.turn.grip = make(this.turn, "circle", { class: "grip" });
    this.turn.dot = make(this.turn, "circle", { class: "turn" });
  }

  buildBody(layer, body, index) {
    const track = make(layer.tracks, "path", { class: `track ${body.role}` });
    const start = make(layer.starts, "g", { class: `body ${body.role}`, "data-act": "move", "data-index": index });
    shapeInto(start, body.shape, "start");
    const group = make(layer.bodies, "g", { class: `body ${body.role}`, role: "button", tabindex: this.hands ? -1 : 0, "data-act": "move", "data-index": index });
    const grip = make(group, "circle", { class: "grip" });
    shapeInto(group, body.shape, "shape");
    const arrow = make(layer.speeds, "g", { class: body.role });
    const shaft = make(arrow, "line", { class: "arrow" });
    const tip = make(arrow, "g", { class: "handle", "data-act": "speed", "data-index": index });
    const reach = make(tip, "circle", { class: "grip" }), head = make(tip, "path", { class: "tip" });
    const word = make(layer.labels, "text", { class: "label", "text-anchor": "middle" });
    return { track, start, group, grip, arrow, shaft, tip, reach, head, word, radius: boundingRadius(body.shape) };
  }

  draw(state) {
    const { situation, view, t, chosen, plans } = state, arm = situation.arm;
    this.state = state;
    this.build(situation);
    set(this.svg, { viewBox: `${-view} ${-view} ${2 * view} ${2 * view}` });
    const unit = (2 * view) / (this.svg.clientWidth || 400);
    this.unit = unit;
    set(this.rims[0], { r: reachOf(arm) });
    set(this.rims[1], { r: Math.abs((arm.upper_arm ?? 1) - 1) });
    situation.bodies.forEach((body, k) => this.drawBody(body, this.parts[k], state, k));
    this.drawArms(arm, plans, t, unit);
    this.drawWays(arm, plans, unit);
    this.drawTurn(situation, chosen, t, unit);
  }

  drawBody(body, part, { situation, t, chosen }, index) {
    const unit = this.unit, pose = poseAt(body, t), start = poseAt(body, 0), speed = body.motion.velocity;
    set(part.group, { transform: place(pose) });
    part.group.classList.toggle("chosen", index === chosen && !this.hands);
    set(part.grip, { r: Math.max(part.radius, 14 * unit) });
    set(part.start, { transform: place(start), visibility: t > 0 && !this.hands ? "visible" : "hidden" });
    const points = Array.from({ length: 31 }, (_, k) => poseAt(body, (k / 30) * situation.horizon)).map((p) => [p.x, p.y]);
    set(part.track, { d: line(points) });
    const size = Math.hypot(...speed), still = size < 1e-9;
    const [dx, dy] = still ? [0, 1] : speed.map((v) => v / size);
    const from = Math.min(part.radius, 0.25), away = from + AHEAD * size + 9 * unit;
    const tip = { x: start.x + dx * away, y: start.y + dy * away, angle: Math.atan2(dy, dx) };
    set(part.arrow, { class: `${body.role}${still ? " still" : ""}`, visibility: this.hands ? "hidden" : "visible" });
    set(part.shaft, { x1: start.x + dx * from, y1: -(start.y + dy * from), x2: tip.x - dx * 7 * unit, y2: -(tip.y - dy * 7 * unit) });
    set(part.tip, { transform: place(tip) });
    set(part.reach, { r: 13 * unit });
    const u = unit;
    set(part.head, { d: still ? `M${-4 * u} 0a${4 * u} ${4 * u} 0 1 0 ${8 * u} 0a${4 * u} ${4 * u} 0 1 0 ${-8 * u} 0Z` : `M${7 * u} 0L${-7 * u} ${6 * u}L${-7 * u} ${-6 * u}Z` });
    this.write(part.word, this.hands ? "" : body.name, pose.x, pose.y - part.radius * (part.radius > 0.25 ? 0.5 : 1) - 14 * unit);
    const [x, y] = body.motion.position;
    set(part.group, { "aria-label": `${body.name}, ${body.role}, at ${x.toFixed(2)}, ${y.toFixed(2)}, velocity ${speed.map((v) => v.toFixed(2)).join(", ")}` });
  }

  write(word, text, x, y) {
    if (word.textContent !== text) word.textContent = text;
    set(word, { x, y: -y, "font-size": 12 * this.unit, "stroke-width": 3 * this.unit });
  }

  drawArms(arm, plans, t, unit) {
    const thick = Math.max(2 * (arm.thickness ?? 0), 5 * unit) / unit; // strokes are in pixels
    const poses = [plans[1]?.trajectory && Infinity, plans[0]?.trajectory && Infinity, plans[1] && t, t];
    const owners = [plans[1], plans[0], plans[1], plans[0]];
    this.arms.forEach((drawn, k) => {
      const shown = !this.hands && (poses[k] || poses[k] === 0), hand = shown ? this.handOf(owners[k], arm, poses[k]) : null;
      const elbow = hand && elbowOf(arm, hand);
      set(drawn.group, { visibility: elbow ? "visible" : "hidden" });
      if (!elbow) return;
      set(drawn.bone, { d: line([[0, 0], elbow, hand]), "stroke-width": thick });
      [[0, 0], elbow].forEach(([x, y], j) => set(drawn.joints[j], { cx: x, cy: -y, r: 5 * unit }));
    });
    const [x, y] = this.handOf(plans[0], arm, t), begin = arm.hand;
    set(this.begin, { cx: begin[0], cy: -begin[1], r: 7 * unit, visibility: t > 0 ? "visible" : "hidden" });
    set(this.hand, { transform: `translate(${x} ${-y})`, "aria-label": `hand, at ${begin.map((v) => v.toFixed(2)).join(", ")}` });
    set(this.hand.grip, { r: 16 * unit });
    set(this.hand.dot, { r: 7 * unit });
    this.write(this.hand.word, this.hands ? "" : "hand", x, y - 20 * unit);
  }

  // At the start the hand is where it was dragged to, also before the answer comes.
  handOf(plan, arm, t) { return t > 0 ? handAt(plan, arm, t) : arm.hand; }

  drawWays(arm, plans, unit) {
    const paths = [plans[1], plans[0], plans[0]].map((plan) => (plan?.trajectory ? line(plan.trajectory.hand) : ""));
    this.ways.forEach((way, k) => set(way, { d: paths[k] }));
    [plans[1], plans[0]].forEach((plan, k) => {
      const end = plan?.trajectory?.hand.at(-1);
      set(this.catches[k], { cx: end?.[0] ?? 0, cy: -(end?.[1] ?? 0), r: 11 * unit, visibility: end ? "visible" : "hidden" });
    });
  }

  drawTurn(situation, chosen, t, unit) {
    const body = situation.bodies[chosen], shown = body && body.shape.kind !== "disc" && !this.hands;
    set(this.turn, { visibility: shown ? "visible" : "hidden" });
    if (!shown) return;
    const { x, y, angle } = poseAt(body, 0), away = this.parts[chosen].radius + 20 * unit;
    const end = [x + away * Math.cos(angle), y + away * Math.sin(angle)];
    set(this.turn.spoke, { x1: x, y1: -y, x2: end[0], y2: -end[1] });
    for (const dot of [this.turn.grip, this.turn.dot]) set(dot, { cx: end[0], cy: -end[1], r: (dot === this.turn.grip ? 14 : 6) * unit });
    this.turn.dataset.index = chosen;
  }

  at(event) {
    const box = this.svg.getBoundingClientRect(), { view } = this.state;
    return [((event.clientX - box.left) / box.width) * 2 * view - view, view - ((event.clientY - box.top) / box.height) * 2 * view];
  }

  press(event) {
    const found = event.target.closest("[data-act]");
    if (!found || event.button > 0) return;
    const index = Number(found.dataset.index), body = this.state.situation.bodies[index];
    const origin = index < 0 ? this.state.situation.arm.hand : body.motion.position;
    this.drag = { act: found.dataset.act, index, from: this.at(event), origin: [...origin] };
    this.svg.setPointerCapture(event.pointerId);
    this.svg.classList.add("dragging");
    event.preventDefault();
    const focused = index < 0 ? this.hand : this.parts[index].group;
    if (!this.hands) focused.focus({ preventScroll: true, focusVisible: false });
    this.choose(index);
  }

  move(event) {
    if (!this.drag) return;
    const { act, index, from, origin } = this.drag, [x, y] = this.at(event), { situation } = this.state;
    const body = situation.bodies[index], [px, py] = body ? body.motion.position : [0, 0];
    if (act === "turn") setAngle(body, Math.atan2(y - py, x - px));
    else if (act === "speed") this.aim(body, this.parts[index].radius, x - px, y - py);
    else this.put(index, [origin[0] + x - from[0], origin[1] + y - from[1]]);
    this.changed("moving");
  }

  aim(body, radius, dx, dy) {
    const away = Math.hypot(dx, dy), size = Math.max(0, away - Math.min(radius, 0.25) - 9 * this.unit) / AHEAD;
    setPair(body, "velocity", away > 0 ? [(size * dx) / away, (size * dy) / away] : [0, 0]);
  }

  put(index, point) {
    const { situation } = this.state;
    if (index < 0) situation.arm.hand = point.map((v) => Math.round(v * 1e4) / 1e4);
    else setPair(situation.bodies[index], "position", point);
  }

  release() {
    if (!this.drag) return;
    this.drag = null;
    this.svg.classList.remove("dragging");
    this.changed("moved");
  }

  key(event) {
    const found = event.target.closest("[data-index]");
    if (!found || event.ctrlKey || event.metaKey) return;
    const index = Number(found.dataset.index), body = this.state.situation.bodies[index], way = KEYS[event.key];
    if (way && event.shiftKey && body) setPair(body, "velocity", body.motion.velocity.map((v, k) => v + SPEED_STEP * way[k]));
    else if (way) {
      const step = event.altKey ? FINE : STEP, origin = body ? body.motion.position : this.state.situation.arm.hand;
      this.put(index, origin.map((v, k) => v + step * way[k]));
    } else if (body && (event.key === "[" || event.key === "]")) setAngle(body, (body.motion.angle ?? 0) + (event.key === "[" ? TURN_STEP : -TURN_STEP));
    else return;
    event.preventDefault();
    this.changed("moved");
  }
}
