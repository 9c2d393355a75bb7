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

// Sends what `question` gives as soon as the last answer is here, and hands each answer to `use`.
export class Stream {
  constructor(kind, question, use, fail) {
    Object.assign(this, { kind, question, use, fail, wanted: false, busy: false });
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
      try {
        const answer = await ask(this.kind, question), took = performance.now() - began;
        if (!answer.dropped) setTimeout(() => this.use(answer, question, took)); // the next question leaves first
      } catch (error) {
        this.fail(error);
        await new Promise((done) => setTimeout(done, 500));
      }
    }
    this.busy = false;
  }
}
