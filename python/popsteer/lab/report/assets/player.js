// The cursor: one value of time or distance, moved by playing, by keys, by the slider and by plots.
const RATES = [0.25, 0.5, 1, 2, 5, 10, 20, 50];
const WATCHED = 25; // seconds in which a run is played, about

class Player {
  constructor(onMove) {
    this.onMove = onMove;
    this.button = document.getElementById("play");
    this.slider = document.getElementById("cursor");
    this.shown = document.getElementById("now");
    this.rate = document.getElementById("rate");
    this.rate.append(...RATES.map((rate) => new Option(`${rate}×`, rate)));
    this.button.addEventListener("click", () => this.toggle());
    this.slider.addEventListener("input", () => this.set(Number(this.slider.value)));
    document.addEventListener("keydown", (event) => this.key(event));
  }

  show(scene, axis) {
    this.stop();
    this.scene = scene;
    this.axis = axis;
    const last = (column) => Math.max(...scene.actors.map((actor) => actor.columns[column].at(-1)));
    this.first = Math.min(...scene.actors.map((actor) => actor.columns[axis][0]));
    this.end = last(axis);
    this.seconds = Math.max(last("time") - Math.min(...scene.actors.map((actor) => actor.columns.time[0])), 1e-3);
    this.step = (this.end - this.first) / 500;
    if (axis === "time") {
      const { time } = scene.actors[0].columns;
      this.step = time.length > 1 ? (time.at(-1) - time[0]) / (time.length - 1) : this.step;
    }
    this.slider.min = this.first;
    this.slider.max = this.end;
  }

  chooseRate() {
    const wanted = this.seconds / WATCHED;
    this.rate.value = RATES.reduce((best, rate) =>
      (Math.abs(Math.log(rate / wanted)) < Math.abs(Math.log(best / wanted)) ? rate : best));
  }

  set(value) {
    this.value = Math.min(Math.max(value, this.first), this.end);
    const text = this.axis === "time" ? `${this.value.toFixed(2)} s` : `${this.value.toFixed(1)} m`;
    this.slider.value = this.value;
    this.slider.setAttribute("aria-valuetext", text);
    this.shown.textContent = text;
    this.onMove(this.value);
  }

  toggle() {
    if (this.playing) this.stop();
    else this.play();
  }

  play() {
    if (this.value >= this.end) this.set(this.first);
    this.playing = true;
    this.button.textContent = "\u275a\u275a";
    this.button.setAttribute("aria-label", "Pause");
    let before;
    const frame = (now) => {
      if (!this.playing) return;
      const passed = before === undefined ? 0 : Math.min(now - before, 100) / 1000;
      before = now;
      // Over distance the cars go side by side, at the mean speed of the run.
      const pace = this.axis === "time" ? 1 : (this.end - this.first) / this.seconds;
      this.set(this.value + passed * pace * Number(this.rate.value));
      if (this.value >= this.end) this.stop();
      else requestAnimationFrame(frame);
    };
    requestAnimationFrame(frame);
  }

  stop() {
    this.playing = false;
    this.button.textContent = "\u25b6\ufe0e";
    this.button.setAttribute("aria-label", "Play");
  }

  key(event) {
    if (!this.scene || event.ctrlKey || event.metaKey || event.altKey) return;
    const { target } = event;
    const own = target === this.slider;
    if (!own && target.closest?.("input, select, textarea, button, summary, a, pre, .scroll")) return;
    const far = event.shiftKey ? 10 : 1;
    const moves = {
      ArrowLeft: () => this.set(this.value - far * this.step),
      ArrowRight: () => this.set(this.value + far * this.step),
      Home: () => this.set(this.first),
      End: () => this.set(this.end),
      " ": () => this.toggle(),
    };
    if (!moves[event.key]) return;
    if (event.key !== " " && event.key.startsWith("Arrow")) this.stop();
    event.preventDefault();
    moves[event.key]();
  }
}
