// A plot over time with a line for each controller, and a cursor.
"use strict";

(() => {
  const { clear, colour, dashes, round125 } = popsteer;
  const MARGIN = { left: 46, right: 8, top: 6, bottom: 32 };

  class Plot {
    /** `pick` is called with the time [s] under a pointer. */
    constructor(canvas, pick) {
      this.canvas = canvas;
      this.duration = 1;
      const point = (event) => {
        if (event.type === "pointermove" && event.buttons === 0) return;
        const box = canvas.getBoundingClientRect();
        const share = (event.clientX - box.left - MARGIN.left) / (box.width - MARGIN.left - MARGIN.right);
        pick(Math.min(Math.max(share, 0), 1) * this.duration);
      };
      for (const kind of ["pointerdown", "pointermove"]) canvas.addEventListener(kind, point);
    }

    /** Draws `lines` of {name, time, values}; `range` bounds the axis, 0 takes in everything. */
    show(lines, duration, now, range) {
      this.duration = duration;
      const { context, width, height } = clear(this.canvas);
      const [across, up] = [width - MARGIN.left - MARGIN.right, height - MARGIN.top - MARGIN.bottom];
      const most = lines.reduce((high, { values }) => values.reduce((so, value) => Math.max(so, Math.abs(value)), high), 1e-3);
      const bound = range || most * 1.05;
      const toX = (time) => MARGIN.left + (time / duration) * across;
      const toY = (value) => MARGIN.top + (0.5 - value / bound / 2) * up;
      drawGrid(context, { toX, toY, bound, duration, width, height });
      context.save();
      context.beginPath();
      context.rect(MARGIN.left, MARGIN.top, across, up);
      context.clip();
      // The first is drawn last: it is on top.
      for (const { name, time, values } of lines.toReversed()) {
        context.beginPath();
        for (let step = 0; step < time.length; step += 1) context.lineTo(toX(time[step]), toY(values[step]));
        context.strokeStyle = colour(name);
        context.lineWidth = 1.5;
        context.setLineDash(dashes(name));
        context.stroke();
      }
      context.restore();
      context.fillStyle = colour("accent");
      context.fillRect(toX(now) - 0.75, MARGIN.top, 1.5, up);
    }
  }

  function drawGrid(context, { toX, toY, bound, duration, width, height }) {
    context.lineWidth = 1;
    context.strokeStyle = colour("grid");
    context.fillStyle = colour("faint");
    const step = round125((2 * bound) / 5);
    const digits = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
    context.textAlign = "right";
    context.textBaseline = "middle";
    for (let count = -Math.floor(bound / step + 1e-9); count * step <= bound * (1 + 1e-9); count += 1) {
      const y = toY(count * step);
      context.beginPath();
      context.moveTo(MARGIN.left, y);
      context.lineTo(width - MARGIN.right, y);
      context.stroke();
      context.fillText((count * step).toFixed(digits).replace("-", "−"), MARGIN.left - 6, y);
    }
    context.textAlign = "center";
    context.textBaseline = "top";
    const tick = round125((duration / Math.max(width - 60, 60)) * 70);
    for (let time = 0; time <= duration; time += tick) {
      context.fillText(`${Number(time.toPrecision(6))}`, toX(time), height - MARGIN.bottom + 5);
    }
    context.textAlign = "right";
    context.fillText("time [s]", width - MARGIN.right, height - 13);
  }

  Object.assign(popsteer, { Plot });
})();
