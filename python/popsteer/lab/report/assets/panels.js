// Quantities over time or distance, one below the other, under one cursor.
const GAP = 0.045;
const NARROW = 480; // pixels

const LEVELS = { degraded: "speed", fault: "pid" }; // the colours that the figures have for them

function legend() {
  const signs = { degraded: "▬", fault: "■" };
  return Object.keys(LEVELS).map((level) => `<span style="color:${role(LEVELS[level])}">${signs[level]}</span> ${level}`).join("  ");
}

class Panels {
  constructor(element, onPick) {
    this.element = element;
    this.onPick = onPick;
    this.line = document.createElement("div");
    this.line.className = "line";
    this.dots = document.createElementNS(SVG, "svg");
    this.dots.setAttribute("class", "dots");
    this.dots.setAttribute("aria-hidden", "true");
    const pick = (event, clicked) => {
      if (!this.scene || event.buttons) return;
      const { xaxis } = element._fullLayout;
      const pixel = event.clientX - element.getBoundingClientRect().left - xaxis._offset;
      if (pixel < 0 || pixel > xaxis._length) return;
      this.onPick(xaxis.p2l(pixel), clicked);
    };
    element.addEventListener("pointermove", (event) => pick(event, false));
    element.addEventListener("click", (event) => pick(event, true));
  }

  async show(scene, axis) {
    this.scene = scene;
    this.axis = axis;
    this.zoomed = false;
    await this.draw();
    this.element.removeAllListeners?.("plotly_relayout");
    this.element.on("plotly_relayout", (changed) => {
      const zoomed = "xaxis.range[0]" in changed || "xaxis.range" in changed;
      if (!zoomed && !("xaxis.autorange" in changed)) return;
      this.zoomed = zoomed;
      this.draw();
    });
    this.element.removeAllListeners?.("plotly_afterplot");
    this.element.on("plotly_afterplot", () => this.place());
    this.place();
  }

  draw() {
    const { scene, axis } = this;
    const panels = scene.panels;
    const weights = panels.map((panel) => (panel.column === "status" ? 0.16 + 0.08 * scene.actors.length : 1));
    const unit = (1 - GAP * (panels.length - 1)) / weights.reduce((sum, each) => sum + each, 0);
    const traces = [], shapes = [], notes = [];
    const ends = (place) => scene.actors.map((actor) => actor.columns[axis].at(place)); // triangles would need room
    const last = panels.length === 1 ? "y" : `y${panels.length}`;
    const layout = layoutStyle({
      ...(printing && { height: 1.2 * SHEET }),
      uirevision: `${scene.title} ${axis}`, // a zoom outlives a change of colours
      showlegend: false, hovermode: false, dragmode: coarse ? false : "zoom", shapes, annotations: notes,
      margin: { l: 8, r: 12, t: 1.9 * letterSize(), b: 8 },
      xaxis: axisStyle({
        title: { text: axis === "time" ? "time [s]" : scene.distanceTitle, standoff: 6 },
        anchor: last, zeroline: false, autorangeoptions: { clipmin: Math.min(...ends(0)), clipmax: Math.max(...ends(-1)) },
      }),
    });
    let top = 1;
    panels.forEach((panel, place) => {
      const name = place ? `y${place + 1}` : "y", full = place ? `yaxis${place + 1}` : "yaxis";
      const bottom = Math.max(0, top - unit * weights[place]);
      const title = `<b>${this.fits(panel.title) ? panel.title : panel.short}</b>`;
      layout[full] = axisStyle({ domain: [bottom, top], fixedrange: true, nticks: 5 });
      notes.push({
        text: panel.column === "status" ? `${title} ${legend()}` : title, xref: "paper", yref: "paper", x: 0, y: top, xanchor: "left",
        yanchor: "bottom", showarrow: false, font: { color: role("text") },
      });
      top = bottom - GAP;
      if (panel.column === "status") this.addStatuses(traces, name, layout[full]);
      else this.addLines(traces, shapes, panel, name, layout[full]);
    });
    return Plotly.react(this.element, traces, layout, plotConfig);
  }

  // Whether a title, beside the marks of the axis, is not cut off.
  fits(title) {
    return 0.62 * letterSize() * title.length < this.element.clientWidth - 6 * letterSize();
  }

  // Calls with each value of a quantity that is looked at, from a time on; where, and whose it is.
  look(panel, start, found) {
    const [from, to] = this.zoomed ? this.element._fullLayout.xaxis.range : [-Infinity, Infinity];
    for (const actor of this.scene.actors) {
      const { time, [panel.column]: values, [this.axis]: along } = actor.columns;
      for (let k = 0; k < (values?.length ?? 0); k++) {
        if (time[k] >= start && along[k] >= from && along[k] <= to) found(values[k], along[k], actor);
      }
    }
  }

  // The range that a quantity takes after the start; where the start alone is looked at, there.
  range(panel) {
    let low = Infinity, high = -Infinity;
    for (const start of [this.scene.settled, -Infinity]) {
      if (low <= high) break;
      this.look(panel, start, (value) => {
        if (value < low) low = value;
        if (value > high) high = value;
      });
    }
    if (panel.limit) [low, high] = [Math.min(low, -panel.limit), Math.max(high, panel.limit)];
    const room = 0.06 * (high - low) || 0.1 * Math.abs(high) || 1;
    return low <= high ? [low - room, high + room] : undefined;
  }

  // The start is faint; a triangle at the edge says which way a line leaves the plot.
  addLines(traces, shapes, panel, name, layout) {
    const range = this.range(panel), beyond = new Map();
    layout.range = range;
    if (range) {
      this.look(panel, -Infinity, (value, at, actor) => {
        if (!(value < range[0] || value > range[1])) return;
        const side = value > range[1] ? "triangle-up" : "triangle-down";
        const marks = beyond.get(actor) ?? beyond.set(actor, new Map()).get(actor);
        if (!(Math.abs(marks.get(side)?.[0]) >= Math.abs(value))) marks.set(side, [value, at]);
      });
    }
    const dashes = dashesOf(this.scene.actors.map((actor) => actor.name));
    for (const [place, actor] of this.scene.actors.entries()) {
      const values = actor.columns[panel.column], along = actor.columns[this.axis];
      if (!values) continue;
      const begun = actor.columns.time.findIndex((time) => time >= this.scene.settled);
      const common = { yaxis: name, hoverinfo: "skip", visible: !actor.hidden, actor: actor.name };
      for (const [first, end, opacity] of begun > 0 ? [[0, begun + 1, 0.35], [begun, undefined, 1]] : [[0, undefined, 1]]) {
        traces.push({
          x: along.slice(first, end), y: values.slice(first, end), mode: "lines", connectgaps: false, opacity,
          line: { color: shade(actor.colour), width: actor.width, dash: dashes[place] }, ...common,
        });
      }
      const marks = [...(beyond.get(actor) ?? [])];
      if (!marks.length) continue;
      traces.push({
        x: marks.map(([, [, at]]) => at), y: marks.map(([side]) => range[side === "triangle-up" ? 1 : 0]),
        mode: "markers", cliponaxis: false, ...common,
        marker: { symbol: marks.map(([side]) => side), size: 8, color: shade(actor.colour) },
      });
    }
    for (const sign of panel.limit ? [-1, 1] : []) {
      shapes.push({
        type: "line", xref: "paper", x0: 0, x1: 1, yref: name, y0: sign * panel.limit,
        y1: sign * panel.limit, line: { color: role("faint"), dash: "dash", width: 1 },
      });
    }
  }

  // A row for each controller: thin where it was degraded, thick where it was at fault, in two colours.
  addStatuses(traces, name, axis) {
    const actors = this.scene.actors.filter((actor) => actor.columns.status);
    Object.assign(axis, {
      range: [actors.length - 0.4, -0.6], tickvals: actors.map((_, k) => k),
      ticktext: actors.map(({ title }) => (title.length > 13 && this.element.clientWidth < NARROW
        ? `${title.slice(0, 12)}…` : title)),
      zeroline: false, showgrid: false,
    });
    actors.forEach((actor, row) => {
      const along = actor.columns[this.axis], bits = actor.columns.status;
      const drawn = { ok: [[], []], degraded: [[], []], fault: [[], []] };
      for (let k = 0; k < bits.length; k++) {
        const [x, y] = drawn[this.scene.statuses[bits[k]][0]];
        if (k && bits[k] !== bits[k - 1]) { x.push(NaN); y.push(NaN); }
        x.push(along[k], along[Math.min(k + 1, bits.length - 1)]);
        y.push(row, row);
        if (k + 1 < bits.length && bits[k] !== bits[k + 1]) { x.push(NaN); y.push(NaN); }
      }
      for (const [level, width] of [["ok", 1], ["degraded", 4], ["fault", 11]]) {
        traces.push({
          x: drawn[level][0], y: drawn[level][1], yaxis: name, mode: "lines", connectgaps: false,
          line: { color: LEVELS[level] ? role(LEVELS[level]) : shade(actor.colour), width, simplify: true }, opacity: level === "ok" ? 0.5 : 1,
          hoverinfo: "skip", visible: !actor.hidden, actor: actor.name,
        });
      }
    });
  }

  place() {
    for (const part of [this.dots, this.line]) {
      if (part.parentNode !== this.element) this.element.append(part);
    }
    if (this.last !== undefined) this.move(this.last);
  }

  // Puts the cursor, and a dot on each line.
  move(value) {
    this.last = value;
    const layout = this.element._fullLayout;
    if (!layout || !this.scene) return;
    const { xaxis } = layout;
    const pixel = xaxis._offset + xaxis.l2p(value);
    const visible = pixel >= xaxis._offset - 1 && pixel <= xaxis._offset + xaxis._length + 1;
    const first = layout.yaxis;
    const end = layout[this.scene.panels.length > 1 ? `yaxis${this.scene.panels.length}` : "yaxis"];
    Object.assign(this.line.style, {
      display: visible ? "" : "none", left: `${pixel}px`, top: `${first._offset}px`,
      height: `${end._offset + end._length - first._offset}px`,
    });
    let used = 0;
    const dots = this.dots.children;
    this.scene.panels.forEach((panel, place) => {
      const axis = layout[place ? `yaxis${place + 1}` : "yaxis"];
      for (const actor of panel.column === "status" ? [] : this.scene.actors) {
        const along = actor.columns[this.axis];
        const here = between(actor.columns[panel.column], sampleAt(along, value));
        if (actor.hidden || !visible || !Number.isFinite(here) || value > along.at(-1)) continue;
        const dot = dots[used] ?? svgPart("circle", { r: 3.5, "stroke-width": 1 }, this.dots);
        used += 1;
        dot.setAttribute("cx", pixel);
        dot.setAttribute("cy", axis._offset + axis.l2p(here));
        dot.setAttribute("fill", shade(actor.colour));
        dot.setAttribute("stroke", role("background"));
      }
    });
    while (dots.length > used) dots[dots.length - 1].remove();
  }
}
