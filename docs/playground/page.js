// The page: runs what the form says, and shows what it came to.
"use strict";

(() => {
  const { CONTROLLERS, Controls, Drawing, Engine, Plot, Refused, TrackMap, commandOf, element, swatch } = popsteer;
  const at = (id) => document.getElementById(id);
  const DT = 0.05;
  // A controller that takes far longer than the others is not waited for, in play and plots.
  const LONGEST = 1.25;

  /** The bytes of a script element, which hold gzip in base64. */
  async function inflate(id) {
    const bytes = Uint8Array.from(atob(at(id).textContent), (letter) => letter.charCodeAt(0));
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
    return new Response(stream).arrayBuffer();
  }

  class Page {
    constructor(engine, tracks) {
      Object.assign(this, { engine, tracks, runs: new Map(), shown: {}, time: 0, duration: 1, playing: false });
      const changed = () => this.render();
      this.map = new TrackMap(at("map"), changed);
      this.drawing = new Drawing(this.map, at("map-note"), (points) => this.drawn(points));
      const pick = (time) => this.seek(time);
      this.plots = { errors: new Plot(at("errors"), pick), angles: new Plot(at("angles"), pick) };
      this.controls = new Controls(tracks, (what) => (what === "track" ? this.setTrack() : this.drive()));
      at("version").textContent = engine.version;
      this.#listen(changed);
    }

    #listen(changed) {
      at("play").addEventListener("click", () => this.play(!this.playing));
      at("time").addEventListener("input", () => this.seek(at("time").valueAsNumber));
      at("draw").addEventListener("click", () => (this.drawing.active ? this.drawing.stop() : this.draw()));
      at("zoom-in").addEventListener("click", () => this.map.zoom(1.25));
      at("zoom-out").addEventListener("click", () => this.map.zoom(0.8));
      at("fit").addEventListener("click", () => {
        at("follow").checked = this.map.following = false;
        this.map.fit();
      });
      at("follow").addEventListener("change", () => {
        this.map.following = at("follow").checked;
        if (!this.map.following) this.map.fit();
        changed();
      });
      at("range").addEventListener("change", changed);
      matchMedia("(prefers-color-scheme: dark)").addEventListener("change", changed);
      new ResizeObserver(() => (this.map.fitted && !this.drawing.active ? this.map.fit() : changed())).observe(at("map"));
      addEventListener("resize", changed);
      addEventListener("hashchange", () => this.restore());
    }

    /** Takes over the address. */
    restore() {
      this.controls.restore(location.hash.slice(1));
      return this.setTrack();
    }

    /** Begins to drive, close up; not for those who want nothing to move by itself. */
    begin() {
      if (matchMedia("(prefers-reduced-motion: reduce)").matches || this.runs.size === 0) return;
      at("follow").checked = this.map.following = true;
      this.play(true);
    }

    setTrack() {
      const name = this.controls.track.value;
      const { title, xy, closed } = this.tracks[name];
      at("track-title").textContent = `${xy.length / 2} waypoints, ${closed ? "a closed lap" : "open"}`;
      at("saving").hidden = name !== "drawn";
      this.#attempt(() => this.engine.setTrack(xy, closed));
      this.map.setTrack(xy, closed);
      this.title = title;
      this.time = 0;
      return this.drive();
    }

    draw() {
      this.play(false);
      at("draw").setAttribute("aria-pressed", "true");
      at("draw").textContent = "Stop drawing";
      at("follow").checked = false;
      this.drawing.start();
    }

    /** Takes the line that was drawn; without one the track stays. */
    drawn(points) {
      at("draw").setAttribute("aria-pressed", "false");
      at("draw").textContent = "Draw a track";
      const made = points && this.#attempt(() => this.engine.draw(points));
      if (!made) {
        this.map.fit();
        return;
      }
      const { waypoints: xy, closed } = made;
      this.tracks.drawn = { title: "Drawn by hand", xy, closed };
      const { track } = this.controls;
      if (!track.querySelector('[value="drawn"]')) track.append(element("option", { value: "drawn", textContent: "Drawn by hand" }));
      track.value = "drawn";
      const lines = Array.from({ length: xy.length / 2 }, (_, index) => `${xy[2 * index]},${xy[2 * index + 1]}`);
      URL.revokeObjectURL(at("save").href);
      at("save").href = URL.createObjectURL(new Blob([`# x [m], y [m]\n${lines.join("\n")}\n`], { type: "text/csv" }));
      this.setTrack();
    }

    /** Does what may be refused; the page says why. */
    #attempt(work) {
      try {
        const done = work();
        this.say("");
        return done;
      } catch (error) {
        if (!(error instanceof Refused)) throw error;
        this.say(error.message);
        return null;
      }
    }

    say(message) {
      at("message").hidden = message === "";
      at("message").textContent = message;
    }

    /** Drives everything anew; what is changed meanwhile is driven afterwards. */
    async drive() {
      this.pending = true;
      if (this.busy) return;
      this.busy = true;
      at("results").setAttribute("aria-busy", "true");
      try {
        while (this.pending) {
          this.pending = false;
          await this.#driveOnce();
        }
      } finally {
        this.busy = false;
        at("results").setAttribute("aria-busy", "false");
      }
    }

    async #driveOnce() {
      const { settings, chosen, address } = this.controls;
      const runs = new Map();
      const refusals = new Set();
      let spent = 0;
      for (const name of chosen) {
        const begun = performance.now();
        try {
          runs.set(name, this.engine.drive(name, settings));
        } catch (error) {
          if (!(error instanceof Refused)) throw error;
          refusals.add(error.message);
        }
        spent += performance.now() - begun;
        // Between two controllers the page answers.
        await new Promise((next) => setTimeout(next));
      }
      this.runs = popsteer.runs = runs;
      this.lines = [...runs].map(([name, run]) => ({
        name,
        time: run.column("time"),
        errors: run.column("cross_track_error"),
        angles: run.column("steer").map((angle) => (angle * 180) / Math.PI),
      }));
      this.duration = durationOf([...runs.values()]);
      this.time = Math.min(this.time, this.duration);
      this.say([...refusals].join("; "));
      this.controls.mark([...refusals][0] ?? "");
      const laps = `${runs.size} ${runs.size === 1 ? "run" : "runs"}`;
      at("cost").textContent = runs.size > 0 ? `The ${laps} took ${spent.toFixed(0)} ms.` : "";
      popsteer.spent = spent;
      history.replaceState(null, "", address ? `#${address}` : location.pathname + location.search);
      const track = this.controls.track.value;
      const command = runs.size > 0 ? commandOf({ settings, chosen }, track, this.tracks[track].closed) : null;
      at("repeating").hidden = command === null;
      at("command").textContent = command ?? "";
      this.#tabulate();
      this.render();
    }

    #tabulate() {
      const rows = [...this.runs].map(([name, { metrics }]) => {
        const numbers = [metrics.mean, metrics.max, metrics.rear_mean, metrics.rms_steer_rate];
        const title = element("th", { scope: "row" }, swatch(name), CONTROLLERS[name]);
        const cells = numbers.map((number) => element("td", { textContent: Number.isFinite(number) ? number.toFixed(4) : "–" }));
        const className = hasFailed(metrics) ? "bad" : "";
        return element("tr", { className }, title, ...cells, element("td", { textContent: endingOf(metrics, this.engine.statuses) }));
      });
      at("rows").replaceChildren(...rows);
      this.#tell();
    }

    /** Says in a sentence what is seen: who stays closest, who strays farthest, and who failed. */
    #tell() {
      const runs = [...this.runs].map(([name, { metrics }]) => ({ title: CONTROLLERS[name], metrics }));
      const good = runs.filter(({ metrics }) => !hasFailed(metrics)).sort((one, other) => one.metrics.max - other.metrics.max);
      const far = ({ metrics }) => `${metrics.max.toFixed(metrics.max < 0.1 ? 3 : 2)} m`;
      const said = good.length > 0 ? [`${good[0].title} stays within ${far(good[0])} of the track`] : [];
      if (good.length > 1) said.push(`${good.at(-1).title} is up to ${far(good.at(-1))} off it`);
      const failed = runs.filter(({ metrics }) => hasFailed(metrics)).map(({ title, metrics }) =>
        element("strong", { className: "bad", textContent: ` ${title}: ${endingOf(metrics, this.engine.statuses)}.` }));
      const sentence = said.length > 0 ? `The same car on the same track, after the first 5 s: ${said.join("; ")}.` : "";
      at("seen").replaceChildren(sentence, ...failed);
    }

    seek(time) {
      this.time = Math.min(Math.max(time, 0), this.duration);
      this.render();
    }

    play(on) {
      this.playing = on;
      at("play").textContent = on ? "Pause" : "Play";
      if (!on) return;
      if (this.time >= this.duration - DT) this.time = 0;
      let before = performance.now();
      const frame = (now) => {
        if (!this.playing) return;
        this.seek(this.time + (Math.max(now - before, 0) / 1000) * Number(at("pace").value));
        before = now;
        if (this.time >= this.duration) this.play(false);
        else requestAnimationFrame(frame);
      };
      requestAnimationFrame(frame);
    }

    /** Shows the present moment, once a frame. */
    render() {
      if (this.awaited) return;
      this.awaited = true;
      requestAnimationFrame(() => {
        this.awaited = false;
        this.#renderNow();
      });
    }

    #renderNow() {
      const { time, duration, lines = [] } = this;
      Object.assign(at("time"), { max: duration, value: time });
      at("clock").textContent = `${time.toFixed(1)} s`;
      at("time").setAttribute("aria-valuetext", `${time.toFixed(1)} s of ${duration.toFixed(1)} s`);
      const wheelbase = this.controls.settings.wheelbase;
      const drawing = this.drawing.active;
      const cars = drawing ? [] : [...this.runs].map(([name, run]) => ({ name, run, wheelbase, pose: poseAt(run, time) }));
      if (drawing) this.map.show([], this.drawing.line);
      else this.map.show(cars);
      const plot = (kind) => lines.map((line) => ({ name: line.name, time: line.time, values: line[kind] }));
      this.plots.errors.show(plot("errors"), duration, time, Number(at("range").value));
      this.plots.angles.show(plot("angles"), duration, time, 0);
    }
  }

  function durationOf(runs) {
    const times = runs.map(({ metrics }) => metrics.time);
    const finished = runs.filter(({ metrics }) => metrics.ending === 0).map(({ metrics }) => metrics.time);
    return Math.max(DT, Math.min(Math.max(0, ...times), LONGEST * Math.min(...finished)));
  }

  /** Where a car is at a time: between the two control steps around it. */
  function poseAt({ rows, columns, steps }, time) {
    if (steps === 0) return null;
    const exact = Math.min(time / DT, steps - 1);
    const [from, share] = [Math.floor(exact), exact % 1];
    const number = (name) => {
      const index = columns.indexOf(name);
      const [before, after] = [from, Math.min(from + 1, steps - 1)].map((step) => rows[step * columns.length + index]);
      return before + share * (after - before);
    };
    return Object.fromEntries(["x", "y", "yaw", "steer"].map((name) => [name, number(name)]));
  }

  /** Whether a run did not finish, or its controller reported a fault. */
  const hasFailed = ({ ending, faults }) => ending !== 0 || faults !== 0;

  /** How a run ended, and the faults that the controller reported. */
  function endingOf({ ending, time, faults }, statuses) {
    const how = ["finished", "out of time", "gave up 50 m off the track"][ending];
    const reported = statuses.filter((_, bit) => (faults >> bit) & 1);
    return [`${how}, ${time.toFixed(1)} s`, ...reported].join("; ");
  }

  async function begin() {
    const engine = await Engine.load(await inflate("module"));
    const tracks = JSON.parse(new TextDecoder().decode(await inflate("tracks")));
    for (const track of Object.values(tracks)) track.xy = Float64Array.from(track.xy);
    const page = new Page(engine, tracks);
    await page.restore();
    page.begin();
  }

  begin().catch((error) => {
    at("message").hidden = false;
    at("message").textContent = `The playground does not run in this browser: ${error.message}`;
  });
})();
