// A situation as it is drawn: poses of bodies, the arm's elbow, the hand along a plan, addresses.
"use strict";

export const FORMAT = "gcm-learn/situation@1";

// Position and angle of a body at time t: a quadratic motion.
export function poseAt(body, t) {
  const m = body.motion, a = m.acceleration ?? [0, 0], v = m.velocity ?? [0, 0];
  return {
    x: m.position[0] + t * (v[0] + 0.5 * t * a[0]),
    y: m.position[1] + t * (v[1] + 0.5 * t * a[1]),
    angle: (m.angle ?? 0) + t * (m.spin ?? 0),
  };
}

export function boundingRadius(shape) {
  return shape.kind === "disc" ? shape.radius : Math.max(...shape.vertices.map(([x, y]) => Math.hypot(x, y)));
}

// The elbow of a hand; null where the hand is out of reach.
export function elbowOf(arm, hand) {
  const rho = arm.upper_arm ?? 1, r = Math.hypot(hand[0], hand[1]);
  const cosine = (rho * rho + r * r - 1) / (2 * rho * r);
  if (!(Math.abs(cosine) <= 1 + 1e-6)) return null;
  const side = arm.elbow === "left" ? 1 : -1;
  const direction = Math.atan2(hand[1], hand[0]) + side * Math.acos(Math.min(1, Math.max(-1, cosine)));
  return [rho * Math.cos(direction), rho * Math.sin(direction)];
}

// The hand of a plan at time t, straight between samples; it rests before and after.
export function handAt(plan, arm, t) {
  const moves = plan?.trajectory;
  if (!moves) return arm.hand;
  const { time, hand } = moves, last = time.length - 1;
  if (t >= time[last]) return hand[last];
  let low = 0, high = last;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (time[middle] <= t) low = middle; else high = middle;
  }
  const span = time[high] - time[low], s = span > 0 ? Math.max(0, (t - time[low]) / span) : 0;
  return [0, 1].map((k) => hand[low][k] + s * (hand[high][k] - hand[low][k]));
}

export const reachOf = (arm) => (arm.upper_arm ?? 1) + 1;

// Half the width of the view: all that the hand reaches, and where bodies start if they are near.
export function viewOf(situation) {
  const reach = reachOf(situation.arm);
  const far = situation.bodies.map((b) => Math.max(...b.motion.position.map(Math.abs)) + Math.min(boundingRadius(b.shape), 0.3) + 0.1);
  return Math.min(Math.max(1.12 * reach, ...far), 1.9 * reach);
}

export const isPlanar = (situation) => situation.format === FORMAT && !situation.plane;

const round = (x) => Math.round(x * 1e4) / 1e4;

// Change a body's field of two numbers by the same field of another place.
export function setPair(body, field, pair) { body.motion[field] = pair.map(round); }

export function setAngle(body, angle) {
  body.motion.angle = round(Math.atan2(Math.sin(angle), Math.cos(angle)));
}

export function newBody(situation, kind) {
  const word = kind === "disc" ? "disc" : "bar", names = new Set(situation.bodies.map((b) => b.name));
  let k = 1;
  while (names.has(`${word} ${k}`)) k += 1;
  const reach = reachOf(situation.arm), angle = 0.9 * situation.bodies.length;
  const shape = kind === "disc" ? { kind, radius: 0.12 }
    : { kind: "polygon", vertices: [[-0.3, -0.05], [0.3, -0.05], [0.3, 0.05], [-0.3, 0.05]] };
  const position = [round(0.75 * reach * Math.cos(angle)), round(0.75 * reach * Math.sin(angle))];
  const motion = { kind: "quadratic", position, velocity: [0, 0], acceleration: [0, 0], angle: 0, spin: 0 };
  return { role: "obstacle", name: `${word} ${k}`, shape, motion };
}

// A situation in the address' fragment: its JSON in base64 that needs no escapes.
export function toFragment(situation) {
  const bytes = new TextEncoder().encode(JSON.stringify(situation));
  const text = btoa(Array.from(bytes, (b) => String.fromCharCode(b)).join(""));
  return "situation=" + text.replaceAll("+", "-").replaceAll("/", "_").replace(/=+$/, "");
}

export function fromFragment(fragment) {
  const match = /situation=([\w-]+)/.exec(fragment);
  if (!match) return null;
  const text = atob(match[1].replaceAll("-", "+").replaceAll("_", "/"));
  return new TextDecoder().decode(Uint8Array.from(text, (c) => c.charCodeAt(0)));
}
