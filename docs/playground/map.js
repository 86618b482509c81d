// The map: the track, what was driven, and the cars.
"use strict";

(() => {
  const { clear, colour, round125 } = popsteer;
  const FOLLOWING = 14; // pixels a metre, of a car of 2.7 m

  class TrackMap {
    constructor(canvas, changed) {
      this.canvas = canvas;
      this.changed = changed; // called where it has to be drawn again
      this.view = { x: 0, y: 0, scale: 1 }; // the middle [m], and pixels a metre
      this.waypoints = new Float64Array();
      this.fitted = true;
      this.following = false;
      this.drawing = false; // a pointer then draws, and does not move the map
      canvas.addEventListener("pointerdown", (event) => this.#grab(event));
      canvas.addEventListener("keydown", (event) => this.#press(event));
      canvas.addEventListener("wheel", (event) => this.#wheel(event), { passive: false });
    }

    setTrack(waypoints, closed) {
      Object.assign(this, { waypoints, closed });
      this.fit();
    }

    /** Shows the whole track. */
    fit() {
      this.fitted = true;
      const [x, y] = [0, 1].map((axis) => this.waypoints.filter((_, index) => index % 2 === axis));
      if (x.length === 0) return;
      const bounds = (values) => values.reduce(([low, high], value) => [Math.min(low, value), Math.max(high, value)], [Infinity, -Infinity]);
      const [[left, right], [low, high]] = [bounds(x), bounds(y)];
      const { clientWidth: width, clientHeight: height } = this.canvas;
      const [across, up] = [right - left + 12, high - low + 12];
      const scale = Math.min(width / across, (height - 44) / up);
      // A little up, for the scale below.
      this.view = { x: (left + right) / 2, y: (low + high) / 2 - 16 / scale, scale };
      this.changed();
    }

    zoom(factor) {
      this.fitted = false;
      this.view.scale = Math.min(Math.max(this.view.scale * factor, 0.05), 400);
      this.changed();
    }

    /** The place [m] under a pointer. */
    placeOf(event) {
      const box = this.canvas.getBoundingClientRect();
      const { x, y, scale } = this.view;
      return [x + (event.clientX - box.left - box.width / 2) / scale, y - (event.clientY - box.top - box.height / 2) / scale];
    }

    #move(right, up) {
      this.fitted = false;
      this.view.x -= right / this.view.scale;
      this.view.y += up / this.view.scale;
      this.changed();
    }

    #grab(event) {
      if (this.drawing || event.button !== 0) return;
      const move = (moved) => this.#move(moved.movementX, moved.movementY);
      const stop = () => this.canvas.removeEventListener("pointermove", move);
      this.canvas.setPointerCapture(event.pointerId);
      this.canvas.addEventListener("pointermove", move);
      for (const end of ["pointerup", "pointercancel"]) this.canvas.addEventListener(end, stop, { once: true });
    }

    #press(event) {
      if (this.drawing || event.ctrlKey || event.metaKey || event.altKey) return;
      const act = {
        ArrowLeft: () => this.#move(40, 0), ArrowRight: () => this.#move(-40, 0),
        ArrowUp: () => this.#move(0, 40), ArrowDown: () => this.#move(0, -40),
        "+": () => this.zoom(1.25), "-": () => this.zoom(0.8), 0: () => this.fit(),
      }[event.key];
      if (!act) return;
      event.preventDefault();
      act();
    }

    #wheel(event) {
      if (!event.ctrlKey) return; // the page scrolls; with ctrl, or two fingers, the map is zoomed
      event.preventDefault();
      this.zoom(Math.exp(-event.deltaY / 200));
    }

    /** Draws the track and `cars` of {name, run, pose, wheelbase}; instead a `line` that is being drawn by hand. */
    show(cars, line = null) {
      const { context, width, height } = clear(this.canvas);
      const present = cars.filter((car) => car.pose);
      if (this.following && present.length > 0) {
        const { pose, wheelbase } = present[0];
        this.view = { x: pose.x, y: pose.y, scale: (FOLLOWING * 2.7) / wheelbase };
      }
      const { x, y, scale } = this.view;
      context.save();
      context.setTransform(context.getTransform().translate(width / 2, height / 2).scale(scale, -scale).translate(-x, -y));
      const pixel = 1 / scale;
      const thick = Math.max(3 * pixel, Math.min(0.4, 8 * pixel));
      if (line) trace(context, line, 0, 2, false, colour("accent"), 3 * pixel);
      else trace(context, this.waypoints, 0, 2, this.closed, colour("path"), thick);
      // The first is drawn last: it is on top.
      for (const { name, run } of cars.toReversed()) {
        const first = run.columns.indexOf("reference_x");
        context.setLineDash(dashes(name).map((length) => length * pixel));
        trace(context, run.rows, first, run.columns.length, false, colour(name), 1.75 * pixel);
      }
      context.setLineDash([]);
      for (const car of present.toReversed()) drawCar(context, car, pixel);
      context.restore();
      drawScale(context, scale, height);
    }
  }

  /** The line style of a controller. */
  const dashes = (name) => (name.endsWith("-unlimited") ? [7, 4] : []);

  function trace(context, numbers, first, step, closed, style, width) {
    context.beginPath();
    for (let at = first; at < numbers.length; at += step) context.lineTo(numbers[at], numbers[at + 1]);
    if (closed) context.closePath();
    context.strokeStyle = style;
    context.lineWidth = width;
    context.stroke();
  }

  /** A car from above, its wheels at the commanded angle; never so small that it cannot be seen. */
  function drawCar(context, { name, pose, wheelbase }, pixel) {
    const length = Math.max(wheelbase, 9 * pixel);
    context.save();
    context.translate(pose.x, pose.y);
    context.rotate(pose.yaw);
    context.scale(length, length);
    context.lineWidth = (1.5 * pixel) / length;
    context.strokeStyle = colour("background");
    context.fillStyle = colour(name);
    context.beginPath();
    context.roundRect(-0.3, -0.33, 1.62, 0.66, 0.12);
    context.globalAlpha = 0.85;
    context.fill();
    context.globalAlpha = 1;
    context.stroke();
    for (const [x, angle] of [[0, 0], [1, pose.steer]]) {
      for (const y of [-0.33, 0.33]) {
        context.save();
        context.translate(x, y);
        context.rotate(angle);
        context.fillStyle = colour("text");
        context.fillRect(-0.13, -0.05, 0.26, 0.1);
        context.restore();
      }
    }
    context.restore();
  }

  function drawScale(context, scale, height) {
    const metres = round125(50 / scale);
    context.fillStyle = context.strokeStyle = colour("faint");
    context.lineWidth = 2;
    context.beginPath();
    context.moveTo(10, height - 16);
    context.lineTo(10, height - 10);
    context.lineTo(10 + metres * scale, height - 10);
    context.lineTo(10 + metres * scale, height - 16);
    context.stroke();
    context.fillText(`${metres} m`, 16, height - 16);
  }

  Object.assign(popsteer, { TrackMap, dashes });
})();
