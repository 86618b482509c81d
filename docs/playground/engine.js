// The WebAssembly module as objects: tracks in, runs out. Works in a browser and in Node.
"use strict";

(() => {
  const TEXTS = { message: 0, controllers: 1, settings: 2, metrics: 3, columns: 4, statuses: 5, version: 6 };

  /** What popsteer refuses, with its reason; everything works on afterwards. */
  class Refused extends Error {}

  /** What one controller came to: metrics by name, and a row of numbers for each control step. */
  class Run {
    constructor(numbers, metrics, columns) {
      this.metrics = Object.fromEntries(metrics.map((name, index) => [name, numbers[index]]));
      this.rows = numbers.subarray(metrics.length);
      this.columns = columns;
      this.steps = this.rows.length / columns.length;
    }

    /** The numbers of one column, a copy. */
    column(name) {
      const [first, width] = [this.columns.indexOf(name), this.columns.length];
      return Float64Array.from({ length: this.steps }, (_, step) => this.rows[step * width + first]);
    }
  }

  class Engine {
    #module;
    #exports;
    #track = null; // to be set again after a fault of the module

    constructor(module, instance) {
      this.#module = module;
      this.#exports = instance.exports;
      for (const name of ["controllers", "settings", "metrics", "columns", "statuses"]) {
        this[name] = this.#text(TEXTS[name]).split(",");
      }
      this.version = this.#text(TEXTS.version);
    }

    static async load(bytes) {
      const { module, instance } = await WebAssembly.instantiate(bytes, {});
      return new Engine(module, instance);
    }

    /** Takes waypoints x, y, x, y, ... [m] as the track. */
    setTrack(waypoints, closed) {
      this.#call(waypoints, (exports) => exports.playground_track(closed ? 1 : 0));
      this.#track = { waypoints: Float64Array.from(waypoints), closed };
    }

    /** Makes a track of a line drawn by hand; answers with its waypoints. */
    draw(points) {
      const closed = this.#call(points, (exports) => exports.playground_draw()) === 2;
      this.#track = { waypoints: this.#output(), closed };
      return this.#track;
    }

    /** Drives a controller along the track; `settings` by name. */
    drive(controller, settings) {
      const numbers = this.settings.map((name) => Number(settings[name] ?? NaN));
      const index = this.controllers.indexOf(controller);
      this.#call(numbers, (exports) => exports.playground_drive(index));
      return new Run(this.#output(), this.metrics, this.columns);
    }

    /** Calls the module with numbers in its room; throws where it refuses. */
    #call(numbers, work) {
      const room = this.#guarded((exports) => exports.playground_room(numbers.length));
      if (room === 0) throw new Refused(this.#text(TEXTS.message));
      new Float64Array(this.#exports.memory.buffer, room, numbers.length).set(numbers);
      const answer = this.#guarded(work);
      if (answer === 0) throw new Refused(this.#text(TEXTS.message));
      return answer;
    }

    /** A fault of the module leaves it in no state to be used: the next call has a fresh one. */
    #guarded(work) {
      try {
        return work(this.#exports);
      } catch (fault) {
        this.#exports = new WebAssembly.Instance(this.#module, {}).exports;
        const { waypoints, closed } = this.#track ?? {};
        if (waypoints) this.setTrack(waypoints, closed);
        throw new Refused(`the module failed (${fault.message}); it was started again`);
      }
    }

    // What leaves is a copy. A call can grow the memory, which moves its buffer: that is asked for
    // last. A text lies where it did until the next call: its place is asked for after its length.
    #output() {
      const length = this.#exports.playground_output_length();
      const place = this.#exports.playground_output();
      return new Float64Array(this.#exports.memory.buffer, place, length).slice();
    }

    #text(what) {
      const length = this.#exports.playground_text_length(what);
      const place = this.#exports.playground_text(what);
      return new TextDecoder().decode(new Uint8Array(this.#exports.memory.buffer, place, length).slice());
    }
  }

  globalThis.popsteer = { Engine, Refused };
})();
