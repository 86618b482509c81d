// Histograms and the like, as they were described; drawn when all else stands.
const whenIdle = window.requestIdleCallback ?? ((work) => setTimeout(work, 30));
let waiting = [];

function drawNext() {
  const plot = waiting.shift();
  if (!plot) return;
  if (plot.isConnected) {
    plot.isDrawn = true;
    drawFigure(plot);
  }
  whenIdle(drawNext);
}

function drawFigure(element) {
  const { figure } = element;
  const height = (figure.height ?? 1) * 21 * letterSize() / 0.78;
  const layout = layoutStyle({
    height, showlegend: true, hovermode: "x", legend: { orientation: "h", x: 0, y: 1.02, yanchor: "bottom" },
    hoverlabel: { bgcolor: role("background"), bordercolor: role("grid"), font: { color: role("text") } },
    dragmode: coarse ? false : "zoom",
  });
  for (const [key, value] of Object.entries(coloured(figure.layout))) {
    layout[key] = key.includes("axis") ? axisStyle({ ...value, zeroline: false }) : value;
  }
  if (figure.traces.length < 2) layout.showlegend = false;
  const traces = figure.traces.map((trace) => {
    const name = String(trace.line?.color).slice(1);
    return LAWS.includes(name) ? { ...trace, line: { dash: dashesOf([name])[0], ...trace.line } } : trace;
  });
  return Plotly.react(element, coloured(traces), layout, plotConfig);
}

function showFigures(gallery, figures) {
  const parts = figures.map((figure, k) => {
    const frame = document.createElement("figure");
    const caption = document.createElement("figcaption");
    const note = document.createElement("span");
    caption.textContent = figure.title;
    note.textContent = figure.note ?? "";
    caption.append(note);
    caption.id = `figure-${k}`;
    const plot = document.createElement("div");
    plot.className = "plot";
    plot.setAttribute("role", "img");
    plot.setAttribute("aria-labelledby", caption.id);
    plot.style.minHeight = "20rem";
    plot.figure = figure;
    frame.append(caption, plot);
    return frame;
  });
  for (const old of gallery.querySelectorAll(".js-plotly-plot")) Plotly.purge(old);
  gallery.replaceChildren(...parts);
  document.getElementById("figures").hidden = !figures.length;
  const idle = !waiting.length;
  waiting = parts.map((frame) => frame.lastElementChild);
  if (idle) whenIdle(drawNext);
}

function redrawFigures(gallery) {
  for (const plot of gallery.querySelectorAll(".plot")) if (plot.isDrawn) drawFigure(plot);
}
