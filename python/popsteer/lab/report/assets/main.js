// Puts the parts together: the choice of scene, axis and view, and what a change of colours does.
const page = JSON.parse(document.getElementById("data").textContent);
const gallery = document.getElementById("gallery");
const view = document.getElementById("view");
let scene, axis = "time", generation = 0;

const player = new Player((value) => {
  map.move(axis, value);
  panels.move(value);
  readout.move(axis, value);
});
const picked = (value, clicked) => {
  if (clicked || !player.playing) player.set(value);
};
const map = new TrackMap(document.getElementById("map"), picked);
const panels = new Panels(document.getElementById("panels"), picked);
const readout = new Readout(document.getElementById("readout"), (actor) => {
  for (const plot of [map.element, panels.element]) {
    const own = plot.data.flatMap((trace, k) => (trace.actor === actor.name ? [k] : []));
    if (own.length) Plotly.restyle(plot, { visible: !actor.hidden }, own);
  }
  player.set(player.value);
});

async function showScene(chosen) {
  const mine = ++generation;
  scene = chosen;
  view.replaceChildren(new Option("whole map", ""));
  for (const [k, actor] of scene.actors.entries()) {
    if (actor.columns.x && actor.body !== "ray") view.append(new Option(`follow ${actor.title}`, k));
  }
  showFigures(gallery, [...page.figures, ...scene.figures]);
  readout.show(scene);
  player.show(scene, axis);
  player.chooseRate();
  await map.show(scene);
  await panels.show(scene, axis);
  if (mine !== generation) return;
  player.set(player.first);
  if (map.isHairline && view.length > 1) {
    view.selectedIndex = 1;
    map.follow(scene.actors[view.value]);
  }
}

async function showAxis(chosen) {
  const before = axis, value = player.value;
  axis = chosen;
  player.show(scene, axis);
  await panels.show(scene, axis);
  player.set(converted(scene.actors[0], before, axis, value));
}

// All that has colours or a width; plotly draws at once, and its promises tell of more.
function redraw() {
  if (!scene) {
    redrawFigures(gallery);
    return;
  }
  const drawn = [map.draw(), panels.draw()];
  readout.colour();
  redrawFigures(gallery);
  map.place();
  return Promise.all(drawn).then(() => player.set(player.value));
}

function listen() {
  const choice = document.getElementById("scene");
  choice.addEventListener("change", () => showScene(page.scenes[choice.value]));
  for (const link of document.querySelectorAll("[data-scene]")) {
    link.addEventListener("click", () => {
      choice.value = link.dataset.scene;
      showScene(page.scenes[choice.value]);
    });
  }
  view.addEventListener("change", () => map.follow(view.value === "" ? null : scene.actors[view.value]));
  for (const choice of document.getElementsByName("axis")) {
    choice.addEventListener("change", () => showAxis(choice.value));
  }
  darkness.addEventListener("change", redraw);
  for (const before of [true, false]) {
    window.addEventListener(before ? "beforeprint" : "afterprint", () => {
      printing = before;
      for (const each of document.querySelectorAll("details:not([open]), details.shut")) {
        each.open = before;
        each.classList.toggle("shut", before);
      }
      redraw();
      if (!before) window.dispatchEvent(new Event("resize")); // plotly takes the windows' widths again
    });
  }
  for (const button of document.querySelectorAll(".copy")) {
    button.addEventListener("click", () => copied(button));
  }
}

// Where the browser does not let a page copy, the text is selected, ready for Ctrl+C.
async function copied(button) {
  const code = button.parentNode.querySelector("code");
  try {
    await navigator.clipboard.writeText(code.textContent);
    button.textContent = "Copied";
  } catch {
    getSelection().selectAllChildren(code);
    button.textContent = "Selected";
  }
  setTimeout(() => { button.textContent = "Copy"; }, 1500);
}

// The library that draws is compressed; as an element of the page it runs as any script.
async function loadPlotly() {
  const library = document.createElement("script");
  library.textContent = new TextDecoder().decode(await inflated(document.getElementById("plotly").textContent));
  document.head.append(library);
}

async function begin() {
  await loadPlotly();
  const read = columnReader(await inflated(page.numbers));
  for (const each of page.scenes) {
    each.paths = each.paths.map((path) => path.map(read));
    for (const actor of each.actors) {
      // Read when they are first needed: a page may hold many scenes.
      const columns = {};
      for (const [name, place] of Object.entries(actor.columns)) {
        Object.defineProperty(columns, name, { get: () => read(place), enumerable: true });
      }
      actor.columns = columns;
    }
  }
  listen();
  if (page.scenes.length) await showScene(page.scenes[0]);
  else showFigures(gallery, page.figures);
  document.documentElement.dataset.ready = Math.round(performance.now());
}

begin().catch((error) => {
  const problem = document.getElementById("problem");
  problem.hidden = false;
  problem.textContent = `The plots could not be drawn: ${error}. This page needs a browser of 2023 or newer.`;
  console.error(error);
});
