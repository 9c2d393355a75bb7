// Results beside the pictures: plans, and the stratum of the situation.
"use strict";

const STRATA = {
  L: ["line", "The hand catches on a straight line."],
  W: ["way round", "The hand goes round an obstacle, but need not wait."],
  Q: ["queueing", "No catch at full speed was found: the hand waits until an obstacle has passed."],
  U: ["unreachable", "No catch is known within the horizon."],
};

const MISSED = { start_blocked: "✗ blocked at the start", error: "✗ no answer" };

export class Plans {
  constructor(place, changed) { Object.assign(this, { place, changed, cards: [] }); }

  offer(planners, chosen) {
    this.cards = [0, 1].map((k) => this.card(k, k ? ["", ...planners] : planners, chosen[k] ?? ""));
    this.place.replaceChildren(...this.cards.map((c) => c.card));
  }

  card(k, names, name) {
    const card = Object.assign(document.createElement("div"), { className: k ? "plan other" : "plan" });
    const label = document.createElement("label"), select = document.createElement("select");
    select.append(...names.map((n) => new Option(n || "nobody", n)));
    Object.assign(select, { value: name, id: `planner-${k}`, onchange: () => this.changed() });
    label.append(k ? "compared with " : "planner ", select);
    const result = Object.assign(document.createElement("span"), { className: "result" }), small = document.createElement("small");
    card.append(label, result, small);
    return { card, select, result, small };
  }

  names() { return this.cards.map((c) => c.select.value).filter(Boolean); }

  // Show results here, and the first one over the picture as well.
  show(plans, verdict) {
    this.cards.forEach(({ result, small }, k) => {
      const [text, style] = plans[k] ? outcome(plans[k]) : ["", ""];
      Object.assign(result, { textContent: text, className: `result ${style}` });
      if (!k) Object.assign(verdict, { textContent: text, className: style });
      small.textContent = plans[k] ? details(plans[k]) : "";
    });
  }
}

// Text and style of a result; a search that was stopped goes on when the drag ends.
function outcome(plan) {
  if (plan.status === "caught") return [`✓ caught ${plan.catch_body} at ${plan.catch_time.toFixed(3)} s`, "caught"];
  if (/deadline/.test(plan.message ?? "")) return ["… no catch yet", ""];
  return [MISSED[plan.status] ?? "✗ no catch", "missed"];
}

function details(plan) {
  const took = plan.planning_ms === undefined ? "" : `planned in ${plan.planning_ms.toFixed(1)} ms`;
  if (plan.status !== "caught") return [plan.message, took].filter(Boolean).join("; ");
  return plan.clearance === null ? took : `${took}; clearance ${plan.clearance.toFixed(3)}`;
}

export class Strata {
  constructor(list, reasons) {
    Object.assign(this, { list, reasons });
    this.items = Object.fromEntries(Object.entries(STRATA).map(([letter, [word, sentence]]) => {
      const item = document.createElement("li"), mark = document.createElement("b"), text = document.createElement("span");
      mark.textContent = letter;
      text.textContent = `${word}: ${sentence}`;
      item.append(mark, text);
      return [letter, item];
    }));
    list.replaceChildren(...Object.values(this.items));
  }

  show(found) {
    for (const [letter, item] of Object.entries(this.items)) {
      item.classList.toggle("found", letter === found.stratum);
      item.toggleAttribute("aria-current", letter === found.stratum);
    }
    this.reasons.replaceChildren(...(found.reasons ?? [found.error]).map((reason) => Object.assign(document.createElement("li"), { textContent: reason })));
  }

  // The situation has changed: what was said is of an earlier one.
  age() { this.show({ reasons: [] }); }
}
