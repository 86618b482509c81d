// The values at the cursor, a row for each actor; its box shows and hides it.
class Readout {
  constructor(table, onToggle) {
    this.table = table;
    this.onToggle = onToggle;
  }

  show(scene) {
    this.scene = scene;
    this.panels = scene.panels;
    const head = document.createElement("tr");
    for (const [place, text] of ["", ...this.panels.map((panel) => panel.short)].entries()) {
      const cell = document.createElement("th");
      cell.scope = "col";
      cell.textContent = text;
      if (place && this.panels[place - 1].column !== "status") cell.className = "number";
      head.append(cell);
    }
    this.table.tHead.replaceChildren(head);
    this.rows = scene.actors.map((actor) => this.row(actor));
    this.table.tBodies[0].replaceChildren(...this.rows);
    this.colour();
  }

  row(actor) {
    const row = document.createElement("tr");
    const name = document.createElement("th");
    name.scope = "row";
    const label = document.createElement("label");
    const box = document.createElement("input");
    box.type = "checkbox";
    box.checked = !actor.hidden;
    box.addEventListener("change", () => {
      actor.hidden = !box.checked;
      this.onToggle(actor);
    });
    const swatch = document.createElement("span");
    swatch.className = "swatch";
    const title = document.createElement("span");
    title.textContent = actor.title;
    label.append(box, swatch, title);
    name.append(label);
    row.append(name, ...this.panels.map((panel) => {
      const cell = document.createElement("td");
      if (panel.column !== "status") cell.className = "number";
      return cell;
    }));
    return row;
  }

  colour() {
    this.scene.actors.forEach((actor, k) => {
      this.rows[k].querySelector(".swatch").style.background = shade(actor.colour);
    });
  }

  move(axis, value) {
    this.scene.actors.forEach((actor, k) => {
      const along = actor.columns[axis];
      const at = sampleAt(along, value);
      this.rows[k].classList.toggle("ended", value > along.at(-1) + 1e-6);
      this.panels.forEach((panel, place) => {
        const cell = this.rows[k].cells[place + 1];
        const column = actor.columns[panel.column];
        let text = "";
        if (column && panel.column === "status") {
          const [level, names] = this.scene.statuses[column[at[0]]];
          text = names.replaceAll("|", ", ");
          cell.className = level;
        } else if (column) {
          const here = between(column, at);
          text = Number.isFinite(here) ? here.toFixed(panel.decimals) : "–";
          text = Number(text) === 0 ? text.replace("-", "") : text.replace("-", "−");
        }
        if (cell.textContent !== text) cell.textContent = text;
      });
    });
  }
}
