// Colours for the system's setting. The style sheet changes by itself; the plots are drawn anew.
const darkness = window.matchMedia("(prefers-color-scheme: dark)");

let printing = false; // on paper: light, and as wide as a sheet
const SHEET = 680; // pixels

function shade(pair) {
  return pair[darkness.matches && !printing ? 1 : 0];
}

function role(name) {
  return shade(page.roles[name]);
}

// Puts colours in the place of "@name", anywhere in a description of a plot.
function coloured(thing) {
  if (typeof thing === "string" && thing.startsWith("@")) return role(thing.slice(1));
  if (Array.isArray(thing)) return thing.map(coloured);
  if (thing && typeof thing === "object") {
    return Object.fromEntries(Object.entries(thing).map(([key, each]) => [key, coloured(each)]));
  }
  return thing;
}

// Dashes of the controllers, as the figures that are files have them; other lines have them in turn.
const LAWS = ["pid", "pure-pursuit", "stanley", "pop", "preview-pop", "mpc"];
const DASHES = ["dash", "dashdot", "dot", "solid", "longdash", "longdashdot"];

function dashesOf(names) {
  let next = names.some((name) => LAWS.includes(name)) ? 0 : DASHES.indexOf("solid");
  return names.map((name) => {
    if (name === "driver") return "solid"; // of a log, and as wide as no other
    return DASHES[LAWS.includes(name) ? LAWS.indexOf(name) : next++ % DASHES.length];
  });
}

function letterSize() {
  return 0.78 * parseFloat(getComputedStyle(document.documentElement).fontSize);
}

function axisStyle(more) {
  return {
    gridcolor: role("grid"), linecolor: role("grid"), zerolinecolor: role("path"),
    tickfont: { color: role("faint") }, automargin: true, ...more,
  };
}

function layoutStyle(more) {
  return {
    paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)",
    font: { family: "system-ui, 'DejaVu Sans', sans-serif", size: letterSize(), color: role("text") },
    margin: { l: 8, r: 10, t: 8, b: 8 }, ...(printing && { width: SHEET, height: 0.55 * SHEET }), ...more,
  };
}

// A finger scrolls the page; a mouse zooms.
const coarse = window.matchMedia("(pointer: coarse)").matches;
const plotConfig = {
  responsive: true, displaylogo: false, displayModeBar: false, doubleClick: "reset+autosize",
  scrollZoom: false,
};
