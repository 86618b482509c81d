// Drawing a track by hand: with a pointer, or with the arrow keys.
"use strict";

(() => {
  const WIDTH = 240; // metres across the map while drawing
  const STEP = 10; // metres of an arrow key
  const HELP = "Draw with the pointer, or with the arrow keys (Enter ends, Escape cancels). Ends that meet make a lap.";

  class Drawing {
    /** `done` is called with the points x, y, x, y, ... [m], or without where drawing is cancelled. */
    constructor(map, note, done) {
      Object.assign(this, { map, note, done, line: null });
      const { canvas } = map;
      canvas.addEventListener("pointerdown", (event) => this.#begin(event));
      canvas.addEventListener("pointermove", (event) => this.#go(event));
      canvas.addEventListener("pointerup", () => this.pointer && this.#end());
      canvas.addEventListener("pointercancel", () => this.pointer && this.stop());
      canvas.addEventListener("keydown", (event) => this.#press(event));
    }

    get active() {
      return this.map.drawing;
    }

    start() {
      const { map } = this;
      map.drawing = true;
      map.canvas.classList.add("drawing");
      map.following = false;
      map.view = { x: 0, y: 0, scale: map.canvas.clientWidth / WIDTH };
      this.line = [];
      this.note.textContent = HELP;
      map.canvas.focus();
      map.changed();
    }

    /** Ends drawing without a track. */
    stop() {
      this.#leave();
      this.done(null);
    }

    #leave() {
      this.map.drawing = false;
      this.map.canvas.classList.remove("drawing");
      this.note.textContent = "";
      Object.assign(this, { line: null, pointer: null });
    }

    #end() {
      const { line } = this;
      this.#leave();
      this.done(line);
    }

    #begin(event) {
      if (!this.active || event.button !== 0) return;
      this.pointer = event.pointerId;
      this.map.canvas.setPointerCapture(event.pointerId);
      this.line = [...this.map.placeOf(event)];
    }

    #go(event) {
      if (!this.active || event.pointerId !== this.pointer) return;
      const between = event.getCoalescedEvents?.() ?? [];
      for (const each of between.length > 0 ? between : [event]) this.line.push(...this.map.placeOf(each));
      this.map.changed();
    }

    #press(event) {
      if (!this.active) return;
      const [right, up] = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key] ?? [0, 0];
      if (event.key === "Escape") this.stop();
      else if (event.key === "Enter") this.#end();
      else if (right === 0 && up === 0) return;
      else {
        if (this.line.length === 0) this.line.push(0, 0);
        const [x, y] = this.line.slice(-2);
        this.line.push(x + STEP * right, y + STEP * up);
        this.map.changed();
      }
      event.preventDefault();
    }
  }

  Object.assign(popsteer, { Drawing });
})();
