// The form: which track, which controllers, which car; and the address that remembers them.
"use strict";

(() => {
  const CONTROLLERS = {
    pop: "POP",
    "preview-pop": "Preview POP",
    "preview-pop-unlimited": "Preview POP, limits unknown",
    "pure-pursuit": "Pure pursuit",
    stanley: "Stanley",
    pid: "PID",
  };
  const CHOSEN = ["pop", "preview-pop", "pure-pursuit"];
  const SLIDERS = [
    { name: "wheelbase", label: "Wheelbase", unit: "m", min: 0.3, max: 8, step: 0.1, value: 2.7 },
    { name: "steer_lag", label: "Lag of the steering", unit: "s", min: 0, max: 0.5, step: 0.01, value: 0.15 },
    { name: "dead_time", label: "Dead time of the steering", unit: "s", min: 0, max: 0.5, step: 0.01, value: 0.15 },
    { name: "max_steer_rate", label: "Largest rate of the wheels", unit: "rad/s", min: 0.1, max: 1.5, step: 0.05, value: 0.4 },
    { name: "speed", label: "Speed", unit: "m/s", min: 1, max: 25, step: 0.5, value: 10 },
    { name: "start_offset", label: "Start to the left of the track", unit: "m", min: -5, max: 5, step: 0.25, value: -2 },
  ];
  const SWITCHES = [
    { name: "slow_in_bends", label: "In a driver: slower in bends, stops at the end and for a fault", value: 0 },
    { name: "known", label: "Controllers know lag, dead time and rate", value: 1 },
  ];
  const TRACK = "racetrack";

  const element = (tag, properties, ...children) => {
    const made = Object.assign(document.createElement(tag), properties);
    made.append(...children);
    return made;
  };
  const swatch = (name) => {
    const line = element("span", { className: name.endsWith("-unlimited") ? "swatch dashed" : "swatch" });
    line.style.borderColor = `var(--${name})`;
    return line;
  };

  class Controls {
    /** `changed` is called with what was changed: "track" or "settings". */
    constructor(tracks, changed) {
      this.changed = changed;
      this.track = document.getElementById("track");
      for (const [name, { title }] of Object.entries(tracks)) {
        this.track.append(element("option", { value: name, textContent: title }));
      }
      this.track.addEventListener("change", () => changed("track"));
      this.boxes = {};
      for (const [name, title] of Object.entries(CONTROLLERS)) {
        this.boxes[name] = this.#box(document.getElementById("controllers"), name, title, swatch(name));
      }
      this.switches = {};
      for (const { name, label } of SWITCHES) {
        this.switches[name] = this.#box(document.getElementById("switches"), name, label);
      }
      this.sliders = {};
      for (const slider of SLIDERS) this.sliders[slider.name] = this.#slider(slider);
      document.getElementById("reset").addEventListener("click", () => {
        this.restore("");
        changed("track");
      });
    }

    #box(into, id, title, ...before) {
      const box = element("input", { type: "checkbox", id });
      box.addEventListener("change", () => this.changed("settings"));
      into.append(element("div", { className: "choice" }, box, ...before, element("label", { htmlFor: id, textContent: title })));
      return box;
    }

    /** A slider and a field for the same number; the field takes numbers beyond the slider's ends. */
    #slider({ name, label, unit, min, max, step }) {
      const range = element("input", { type: "range", id: name, min, max, step });
      const field = element("input", { type: "number", step: "any", id: `${name}-field` });
      field.setAttribute("aria-label", `${label} [${unit}]`);
      range.addEventListener("input", () => {
        field.value = range.value;
        this.changed("settings");
      });
      field.addEventListener("input", () => {
        range.value = field.value;
        this.changed("settings");
      });
      const title = element("label", { htmlFor: name, textContent: label });
      const row = element("div", { className: "slider" }, title, range, field, element("span", { textContent: unit }));
      document.getElementById(name === "start_offset" ? "switches" : "sliders").append(row);
      return { range, field };
    }

    /** The names of the controllers to drive. */
    get chosen() {
      return Object.keys(CONTROLLERS).filter((name) => this.boxes[name].checked);
    }

    /** The settings by name; what is no number is NaN. */
    get settings() {
      const numbers = SLIDERS.map(({ name }) => [name, this.sliders[name].field.valueAsNumber]);
      const flags = SWITCHES.map(({ name }) => [name, this.switches[name].checked ? 1 : 0]);
      return Object.fromEntries([...numbers, ...flags]);
    }

    /** Marks the field that a refusal names. */
    mark(refusal) {
      for (const [name, { field }] of Object.entries(this.sliders)) {
        field.setAttribute("aria-invalid", refusal.startsWith(`${name} `));
      }
    }

    /** What differs from the defaults, as the address has it. */
    get address() {
      const { settings } = this;
      const different = [...SLIDERS, ...SWITCHES].filter(({ name, value }) => settings[name] !== value);
      const parts = different.map(({ name }) => [name, String(settings[name])]);
      if (this.chosen.join() !== CHOSEN.join()) parts.unshift(["controllers", this.chosen.join()]);
      if (![TRACK, "drawn"].includes(this.track.value)) parts.unshift(["track", this.track.value]);
      return parts.map(([name, value]) => `${name}=${value}`).join("&");
    }

    /** Takes over an address; what it does not name gets its default. */
    restore(address) {
      const given = new URLSearchParams(address);
      const known = [...this.track.options].map((option) => option.value);
      this.track.value = known.includes(given.get("track")) ? given.get("track") : TRACK;
      const chosen = given.get("controllers")?.split(",") ?? CHOSEN;
      for (const [name, box] of Object.entries(this.boxes)) box.checked = chosen.includes(name);
      for (const { name, value } of SLIDERS) {
        const { range, field } = this.sliders[name];
        field.value = range.value = given.get(name) ?? value;
      }
      for (const { name, value } of SWITCHES) this.switches[name].checked = Number(given.get(name) ?? value) > 0.5;
    }
  }

  /** The command that drives the same; none where the command line has no such run. */
  function commandOf({ settings, chosen }, track, closed) {
    if (settings.slow_in_bends > 0.5) return null;
    const { wheelbase, steer_lag, dead_time, max_steer_rate } = settings;
    const plant = { wheelbase, steer_lag, dead_time, max_steer_rate, max_steer: 0.6 };
    const all = [
      "--preset default --set-run settling_time=5",
      track === "drawn" ? `--waypoints drawn.csv${closed ? " --closed" : ""}` : `--track ${track}`,
      "--plant kinematic-bicycle",
      ...Object.entries(plant).map(([name, value]) => `--set-plant ${name}=${value}`),
      `--constant-speed ${settings.speed}`,
      `--start-offset=${settings.start_offset}`,
    ];
    const given = settings.known > 0.5 ? [] : ["steer_lag=0", "dead_time=0", "max_steer_rate=none"];
    const line = (names, vehicle) => {
      const options = [`--controllers ${names.join(",")}`, ...all, ...vehicle.map((field) => `--set-vehicle ${field}`)];
      return `popsteer compare ${options.join(" \\\n    ")}`;
    };
    const limited = chosen.filter((name) => !name.endsWith("-unlimited"));
    const lines = limited.length > 0 ? [line(limited, given)] : [];
    if (limited.length < chosen.length) {
      lines.push(line(["preview-pop"], [...new Set([...given, "max_steer_rate=none"])]));
    }
    return lines.join("\n");
  }

  Object.assign(popsteer, { CONTROLLERS, Controls, commandOf, element, swatch });
})();
