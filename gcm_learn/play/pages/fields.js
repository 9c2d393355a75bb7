// Numbers of the chosen body or of the arm, as fields; and the buttons that choose.
"use strict";
import { boundingRadius } from "./model.js";

const number = (label, get, put, step = 0.05, extra = {}) => ({ label, get, put, step, ...extra });

function pair(label, holder, field) {
  return ["x", "y"].map((axis, k) => number(`${label} ${axis}`, () => holder[field]?.[k] ?? 0, (v) => {
    holder[field] = Object.assign([...(holder[field] ?? [0, 0])], { [k]: v });
  }));
}

function scale(shape) {
  if (shape.kind === "disc") return number("radius", () => shape.radius, (v) => { shape.radius = v; }, 0.01);
  return number("size", () => boundingRadius(shape), (v) => {
    const share = v / boundingRadius(shape);
    if (share > 0) shape.vertices = shape.vertices.map((p) => p.map((x) => Math.round(x * share * 1e6) / 1e6));
  });
}

function bodyFields(body) {
  const m = body.motion;
  return [
    scale(body.shape), { label: "role", choices: ["target", "obstacle"], get: () => body.role, put: (v) => { body.role = v; } },
    ...pair("position", m, "position"), ...pair("velocity", m, "velocity"), ...pair("acceleration", m, "acceleration"),
    number("angle [rad]", () => m.angle ?? 0, (v) => { m.angle = v; }, 0.1), number("spin [rad/s]", () => m.spin ?? 0, (v) => { m.spin = v; }, 0.5),
  ];
}

function armFields(situation) {
  const arm = situation.arm;
  const one = (label, field, value, step) => number(label, () => arm[field] ?? value, (v) => { arm[field] = v; }, step);
  return [
    ...pair("hand", arm, "hand"), one("hand's speed", "max_hand_speed", 3, 0.1), one("upper arm", "upper_arm", 1, 0.05),
    one("thickness", "thickness", 0, 0.01), one("grasp", "grasp", 0.05, 0.01),
    { label: "elbow", choices: ["right", "left"], get: () => arm.elbow ?? "right", put: (v) => { arm.elbow = v; } },
    number("horizon [s]", () => situation.horizon, (v) => { situation.horizon = v; }, 0.1),
  ];
}

export class Fields {
  constructor(list, place, { choose, changed }) {
    Object.assign(this, { list, place, choose, changed, made: "", shown: [] });
  }

  draw(situation, chosen) {
    const form = JSON.stringify([chosen, situation.bodies.map((b) => [b.name, b.role, b.shape.kind])]);
    if (form !== this.made || situation !== this.situation) this.build(situation, chosen);
    Object.assign(this, { made: form, situation });
    for (const [field, input] of this.shown) {
      if (input === document.activeElement) continue;
      const value = field.get();
      input.value = field.choices ? value : Math.round(value * 1000) / 1000;
    }
  }

  build(situation, chosen) {
    const names = [["arm", -1], ...situation.bodies.map((b, k) => [b.name, k])];
    this.list.replaceChildren(...names.map(([name, k]) => {
      const button = Object.assign(document.createElement("button"), { type: "button", onclick: () => this.choose(k) });
      const dot = Object.assign(document.createElement("i"), { className: k < 0 ? "arm" : situation.bodies[k].role });
      button.append(dot, name);
      button.setAttribute("aria-pressed", String(k === chosen));
      return button;
    }));
    const fields = chosen < 0 ? armFields(situation) : bodyFields(situation.bodies[chosen]);
    this.shown = fields.map((field) => [field, this.input(field)]);
    this.place.replaceChildren(...this.shown.map(([field, input]) => {
      const label = document.createElement("label");
      label.append(field.label, input);
      return label;
    }));
  }

  input(field) {
    const input = document.createElement(field.choices ? "select" : "input");
    if (field.choices) input.append(...field.choices.map((c) => new Option(c)));
    else Object.assign(input, { type: "number", step: field.step });
    input.oninput = () => {
      const value = field.choices ? input.value : input.valueAsNumber;
      if (Number.isNaN(value)) return;
      field.put(value);
      this.changed("moved");
    };
    return input;
  }
}
