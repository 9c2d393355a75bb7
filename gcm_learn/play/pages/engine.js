// Questions to the engine: one in flight, the newest waits, older ones are never sent.
"use strict";

const page = Math.random().toString(36).slice(2);

export async function ask(kind, question = {}) {
  const response = await fetch(kind, {
    method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify({ ...question, page }),
  });
  if (!response.ok) throw new Error(`the engine refused the question (${response.status})`);
  return response.json();
}

const LATE = 1500; // [ms]

// Sends what `question` gives as soon as the last answer is here, and hands each answer to `use`.
// An answer that takes long is announced by `late(true)`, and its end by `late(false)`.
export class Stream {
  constructor(kind, question, use, { fail, late }) {
    Object.assign(this, { kind, question, use, fail, late, wanted: false, busy: false });
  }

  want() {
    this.wanted = true;
    if (!this.busy) this.run();
  }

  async run() {
    this.busy = true;
    while (this.wanted) {
      this.wanted = false;
      const question = this.question(), began = performance.now();
      let announced = false;
      const timer = setTimeout(() => { announced = true; this.late(true); }, LATE);
      try {
        const answer = await ask(this.kind, question), took = performance.now() - began;
        if (!answer.dropped) setTimeout(() => this.use(answer, question, took)); // the next question leaves first
      } catch (error) {
        this.fail(error);
        await new Promise((done) => setTimeout(done, 500));
      } finally {
        clearTimeout(timer);
        if (announced) this.late(false);
      }
    }
    this.busy = false;
  }
}
