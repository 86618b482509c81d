"""The plots of a page without a browser: what its code gives plotly to draw."""

from __future__ import annotations

import json
import shutil
import subprocess
from importlib import resources
from typing import Any

import pytest

from popsteer.lab.common.theme import THEMES

NODE = shutil.which("node")
pytestmark = pytest.mark.skipif(NODE is None, reason="node is not on the path")

# A page of three cars, of which the first begins 2 m beside its path, drawn and then zoomed.
PAGE = """
const window = { matchMedia: () => ({ matches: false }) };
const none = () => {};
const empty = { setAttribute: none, addEventListener: none, append: none, children: [] };
const part = () => ({ ...empty, style: {} });
const document = { createElement: part, createElementNS: part, documentElement: {} };
const getComputedStyle = () => ({ fontSize: "16px" });
const SVG = "";
const role_names = ["background", "text", "faint", "grid", "path", "speed", "pid"];
const page = { roles: Object.fromEntries(role_names.map((name) => [name, [name, name]])) };
const drawn = [], handlers = {};
const Plotly = { react: (element, traces, layout) => {
  const copied = traces.map((each) => ({ ...each, x: [...each.x], y: [...each.y] }));
  drawn.push({ traces: copied, layout });
} };
%s
const time = Float64Array.from({ length: 101 }, (_, k) => 0.1 * k);
const error = time.map((t) => (t < 2 ? 2 - t : 0.1 * Math.sin(t)));
const status = time.map((t) => (t < 5 ? 0 : t < 8 ? 1 : 2));
const car = (name, values) => ({
  name, title: name, colour: [name, name], width: 1,
  columns: { time, distance: time, error: values, status },
});
const scene = {
  title: "", settled: 2, statuses: { 0: ["ok", ""], 1: ["degraded", ""], 2: ["fault", ""] },
  actors: [
    car("pop", error), car("stanley", time.map(() => 0.05)), car("mine", time.map(() => NaN)),
  ],
  panels: ["error", "status"].map((column) => ({ column, title: column, short: column })),
};
const element = {
  clientWidth: 900, ...part(), on: (name, what) => { handlers[name] = what; },
  _fullLayout: null,
};
const panels = new Panels(element, () => {});
(async () => {
  await panels.show(scene, "time");
  element._fullLayout = { xaxis: { range: [0, 1] } };
  handlers.plotly_relayout({ "xaxis.range[0]": 0, "xaxis.range[1]": 1 });
  handlers.plotly_relayout({ "yaxis.range": 1 });
  handlers.plotly_relayout({ "xaxis.autorange": true });
  const dashes = [dashesOf(["a", "b"]), dashesOf(["driver", "pop", "a"])];
  console.log(JSON.stringify([drawn, ...dashes, LAWS, DASHES]));
})();
"""


@pytest.fixture(scope="module")
def told() -> list[Any]:
    assets = resources.files("popsteer.lab.report") / "assets"
    code = "".join((assets / f"{name}.js").read_text("utf-8") for name in ("theme", "panels"))
    assert NODE is not None
    done = subprocess.run(
        [NODE, "-"], input=PAGE % code, capture_output=True, encoding="utf-8", check=False
    )
    assert done.stderr == ""
    found: list[Any] = json.loads(done.stdout)
    return found


def _of(drawn: dict[str, Any], actor: str, axis: str, mode: str = "lines") -> list[dict[str, Any]]:
    here = (each for each in drawn["traces"] if each["actor"] == actor and each["yaxis"] == axis)
    return [each for each in here if each["mode"] == mode]


def test_start_is_faint_and_does_not_own_the_axis(told: list[Any]) -> None:
    (whole, *_), *_ = told
    start, rest = _of(whole, "pop", "y")
    assert (start["opacity"], rest["opacity"]) == (0.35, 1)
    assert start["x"][-1] == rest["x"][0] == pytest.approx(2.0)
    low, high = whole["layout"]["yaxis"]["range"]
    assert -0.12 < low < -0.1
    assert 0.1 < high < 0.12
    # The greatest error of the start is marked at the edge that it lies beyond.
    (mark,) = _of(whole, "pop", "y", "markers")
    assert (mark["x"], mark["y"], mark["marker"]["symbol"]) == ([0], [high], ["triangle-up"])
    assert not _of(whole, "stanley", "y", "markers") + _of(whole, "mine", "y", "markers")


def test_axis_fits_what_is_zoomed_to_and_all_again(told: list[Any]) -> None:
    drawn, *_ = told
    whole, near, again = drawn  # nothing is drawn anew where another axis changes
    low, high = near["layout"]["yaxis"]["range"]
    assert low < 0.05
    assert 2.0 < high < 2.2
    assert not _of(near, "pop", "y", "markers")
    assert again == whole


def test_degraded_and_fault_have_two_colours_and_a_legend(told: list[Any]) -> None:
    (whole, *_), *_ = told
    lines = [(each["line"]["color"], each["line"]["width"]) for each in _of(whole, "pop", "y2")]
    assert lines == [("pop", 1), ("speed", 4), ("pid", 11)]
    said = whole["layout"]["annotations"][1]["text"]
    assert '<span style="color:speed">▬</span> degraded' in said
    assert '<span style="color:pid">■</span> fault' in said


def test_lines_differ_by_the_dashes_that_figures_in_files_have(told: list[Any]) -> None:
    (whole, *_), alone, with_driver, laws, dashes = told
    assert laws == list(THEMES["light"].laws)
    known = {"--": "dash", "-.": "dashdot", "-": "solid"}
    styles = THEMES["light"].styles(laws).values()
    assert [known.get(each) for each in styles if isinstance(each, str)] == [
        each for each in dashes if each in known.values()
    ]
    assert len(set(dashes)) == len(dashes) == len(laws)
    assert [_of(whole, name, "y")[0]["line"]["dash"] for name in ("pop", "stanley", "mine")] == [
        "solid",
        "dot",
        "dash",
    ]
    assert alone == ["solid", "longdash"]
    assert with_driver == ["solid", "solid", "dash"]
