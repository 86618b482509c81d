// The map: plotly draws paths and trajectories, cars move on a layer above.
const SVG = "http://www.w3.org/2000/svg";
const SMALLEST = 26; // pixels of a car, at least
const WINDOW = 45; // metres of map around a car that is followed
const HAIRLINE = 12; // times as long as wide: the whole of such a map shows a line

function svgPart(kind, attributes, parent) {
  const part = document.createElementNS(SVG, kind);
  for (const [name, value] of Object.entries(attributes)) part.setAttribute(name, value);
  parent.append(part);
  return part;
}

class TrackMap {
  constructor(element, onPick) {
    this.element = element;
    this.onPick = onPick;
    this.layer = document.createElementNS(SVG, "svg");
    this.layer.setAttribute("class", "overlay");
    this.layer.setAttribute("aria-hidden", "true");
    this.follows = null;
    this.busy = false;
    element.addEventListener("pointermove", (event) => this.pick(event, false));
    element.addEventListener("click", (event) => this.pick(event, true));
  }

  async show(scene) {
    this.scene = scene;
    this.follows = null;
    await this.draw();
    const afterwards = () => this.place();
    this.element.removeAllListeners?.("plotly_afterplot");
    this.element.on("plotly_afterplot", afterwards);
    this.place();
  }

  traces() {
    const { scene } = this;
    const traces = scene.paths.map(([x, y]) => ({
      x, y, mode: "lines", line: { color: role("path"), width: 5 }, hoverinfo: "skip", showlegend: false,
    }));
    const dashes = dashesOf(scene.actors.map((actor) => actor.name));
    for (const [k, actor] of scene.actors.entries()) {
      if (!actor.columns.x || actor.body === "ray") continue;
      traces.push({
        x: actor.columns.x, y: actor.columns.y, mode: "lines", connectgaps: false, hoverinfo: "skip",
        line: { color: shade(actor.colour), width: actor.width, dash: dashes[k] }, visible: !actor.hidden, actor: actor.name,
      });
    }
    if (scene.marks.length) {
      traces.push({
        x: scene.marks.map((mark) => mark[0]), y: scene.marks.map((mark) => mark[1]),
        text: scene.marks.map((mark) => mark[2]), mode: "markers", hovertemplate: "%{text}<extra></extra>",
        marker: { symbol: "x", size: 9, color: role("text") }, showlegend: false,
      });
    }
    return traces;
  }

  draw() {
    this.centre = undefined; // the map of a car that is followed is put there again
    const layout = layoutStyle({
      uirevision: this.scene.title,
      showlegend: false, hovermode: "closest", dragmode: coarse ? false : "zoom",
      xaxis: axisStyle({ title: { text: "x [m]", standoff: 4 }, zeroline: false, ...this.margin("x") }),
      yaxis: axisStyle({ title: { text: "y [m]", standoff: 4 }, zeroline: false, scaleanchor: "x", ...this.margin("y") }),
    });
    return Plotly.react(this.element, this.traces(), layout, { ...plotConfig, scrollZoom: !coarse });
  }

  // The ends of what is drawn.
  ends(axis) {
    const { actors, paths } = this.scene;
    let low = Infinity, high = -Infinity;
    for (const values of [...actors.map((actor) => actor.columns[axis] ?? []), ...paths.map((path) => path[axis === "x" ? 0 : 1])]) {
      for (const value of values) {
        if (value < low) low = value;
        if (value > high) high = value;
      }
    }
    return [low, high];
  }

  get isHairline() {
    const [across, up] = ["x", "y"].map((axis) => this.ends(axis)).map(([low, high]) => high - low);
    return Math.max(across, up) > Math.max(HAIRLINE * Math.min(across, up), 2 * WINDOW);
  }

  // Room for a car at the ends, which would be at the frame.
  margin(axis) {
    const [low, high] = this.ends(axis);
    const room = 0.05 * (high - low);
    return high > low ? { autorangeoptions: { include: [low - room, high + room] } } : {};
  }

  // Fits the layer to the area of the plot, and makes the cars.
  place() {
    const { xaxis, yaxis } = this.element._fullLayout;
    Object.assign(this.layer.style, {
      left: `${xaxis._offset}px`, top: `${yaxis._offset}px`,
      width: `${xaxis._length}px`, height: `${yaxis._length}px`,
    });
    if (this.layer.parentNode !== this.element) this.element.append(this.layer);
    if (this.made !== this.scene || this.wasDark !== darkness.matches) this.make();
    if (this.last !== undefined) this.move(...this.last);
  }

  make() {
    this.layer.replaceChildren();
    this.made = this.scene;
    this.wasDark = darkness.matches;
    const { car } = this.scene;
    this.shapes = this.scene.actors.map((actor) => {
      const colour = shade(actor.colour);
      const group = svgPart("g", { "data-actor": actor.name }, this.layer);
      const line = { stroke: colour, "stroke-width": 2.5, "vector-effect": "non-scaling-stroke", fill: "none" };
      if (actor.body === "dot") {
        svgPart("circle", { r: 6, fill: colour, stroke: role("background"), "stroke-width": 1.5 }, group);
        return { group, wheels: [] };
      }
      if (actor.body === "ray") {
        const ray = svgPart("g", {}, group);
        svgPart("line", { x1: 0, y1: 0, x2: 1.3 * (car.front - car.rear), y2: 0, ...line }, ray);
        return { group, wheels: [[ray, car.front, 0]] };
      }
      const length = car.nose - car.tail;
      svgPart("rect", {
        x: car.tail, y: -car.half, width: length, height: 2 * car.half, rx: 0.3 * car.half,
        fill: colour, "fill-opacity": 0.75, stroke: role("background"), "stroke-width": 1,
        "vector-effect": "non-scaling-stroke",
      }, group);
      const glass = car.front - 0.45 * (car.front - car.rear);
      svgPart("rect", {
        x: glass, y: -0.7 * car.half, width: 0.14 * length, height: 1.4 * car.half,
        fill: role("background"), "fill-opacity": 0.7,
      }, group);
      const wheels = [];
      for (const [ahead, turns] of [[car.rear, false], [car.front, true]]) {
        for (const side of [-0.92 * car.half, 0.92 * car.half]) {
          const wheel = svgPart("g", {}, group);
          const size = 0.075 * length;
          svgPart("rect", {
            x: -size, y: -0.45 * size, width: 2 * size, height: 0.9 * size, fill: role("text"),
          }, wheel);
          wheel.setAttribute("transform", `translate(${ahead} ${side})`);
          if (turns) wheels.push([wheel, ahead, side]);
        }
      }
      return { group, wheels };
    });
  }

  // Puts the cars where they are at a place of the cursor.
  move(axis, value) {
    this.last = [axis, value];
    if (!this.shapes) return;
    const { xaxis, yaxis } = this.element._fullLayout;
    const [left, right] = xaxis.range, [bottom, top] = yaxis.range;
    const scale = xaxis._length / (right - left);
    const { car } = this.scene;
    const length = car.nose - car.tail;
    const larger = Math.max(1, SMALLEST / (scale * length));
    const note = document.getElementById("map-note");
    const said = larger > 1.05 ? `The cars are drawn ${larger.toFixed(larger < 10 ? 1 : 0)} times as large as they are.` : "";
    if (note.textContent !== said) note.textContent = said;
    this.scene.actors.forEach((actor, k) => {
      const { group, wheels } = this.shapes[k];
      const at = sampleAt(actor.columns[axis], value);
      const x = between(actor.columns.x, at), y = between(actor.columns.y, at);
      const shown = !actor.hidden && Number.isFinite(x) && Number.isFinite(y);
      group.style.display = shown ? "" : "none";
      if (!shown) return;
      const px = (x - left) * scale, py = (top - y) * yaxis._length / (top - bottom);
      if (actor.body === "dot") {
        group.setAttribute("transform", `translate(${px} ${py})`);
        return;
      }
      const yaw = angleBetween(actor.columns.yaw, at);
      const c = Math.cos(yaw) * scale * larger, s = Math.sin(yaw) * scale * larger;
      group.setAttribute("transform", `matrix(${c} ${-s} ${-s} ${-c} ${px} ${py})`);
      group.style.opacity = value > actor.columns[axis].at(-1) ? 0.45 : 1;
      const steer = between(actor.columns.steer_deg, at) || 0;
      for (const [wheel, ahead, side] of wheels) {
        wheel.setAttribute("transform", `translate(${ahead} ${side}) rotate(${steer})`);
      }
    });
    this.keepInView(axis, value);
  }

  // Moves the map with the car that is followed; a frame at a time, as it takes longer than one.
  keepInView(axis, value) {
    if (!this.follows || this.busy) return;
    const at = sampleAt(this.follows.columns[axis], value);
    const x = between(this.follows.columns.x, at), y = between(this.follows.columns.y, at);
    if (!Number.isFinite(x) || this.centre === `${x},${y}`) return;
    this.centre = `${x},${y}`;
    this.busy = true;
    const { xaxis, yaxis } = this.element._fullLayout;
    const half = 0.5 * Math.max(WINDOW, 6 * (this.scene.car.nose - this.scene.car.tail));
    const up = half * yaxis._length / xaxis._length;
    Plotly.relayout(this.element, {
      "xaxis.range": [x - half, x + half], "yaxis.range": [y - up, y + up],
    }).finally(() => { this.busy = false; });
  }

  follow(actor) {
    this.follows = actor;
    this.centre = undefined;
    if (actor && this.last) this.keepInView(...this.last);
    else if (!actor) Plotly.relayout(this.element, { "xaxis.autorange": true, "yaxis.autorange": true });
  }

  // The pointer takes the cursor to the nearest place of a trajectory.
  pick(event, clicked) {
    if (!this.scene || event.buttons || !this.last) return;
    const box = this.element.getBoundingClientRect();
    const { xaxis, yaxis } = this.element._fullLayout;
    const x = xaxis.p2l(event.clientX - box.left - xaxis._offset);
    const y = yaxis.p2l(event.clientY - box.top - yaxis._offset);
    const reach = 20 * (xaxis.range[1] - xaxis.range[0]) / xaxis._length;
    let best = reach * reach, found;
    for (const actor of this.scene.actors) {
      const { x: xs, y: ys } = actor.columns;
      if (actor.hidden || !xs) continue;
      for (let k = 0; k < xs.length; k++) {
        const far = (xs[k] - x) ** 2 + (ys[k] - y) ** 2;
        if (far < best) { best = far; found = actor.columns[this.last[0]][k]; }
      }
    }
    if (found !== undefined) this.onPick(found, clicked);
  }
}
