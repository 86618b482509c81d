"""What a table says, cell by cell, and rows of a sweep whose right answers are known by hand."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from rich.text import Text

import popsteer
from popsteer.errors import ConfigError
from popsteer.lab import sweep
from popsteer.lab.common.varied import distribution
from popsteer.lab.sweep.summary import ERROR

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from matplotlib.artist import Artist
    from matplotlib.figure import Figure
    from numpy.typing import ArrayLike, NDArray
    from rich.table import Table

STRAIGHT = popsteer.Path([(float(x), 0.0) for x in range(81)], speed=[5.0] * 81)


def cells(table: Table) -> list[list[str]]:
    """Give the head and the rows of a table as plain text."""
    columns = [[column.header, *column.cells] for column in table.columns]
    plain = [[each.plain if isinstance(each, Text) else str(each) for each in c] for c in columns]
    return [list(row) for row in zip(*plain, strict=True)]


def job(**changes: Any) -> sweep.Job:
    """A sweep of four that nobody drives: its rows are `row`'s."""
    texts = {"steer_lag": "uniform(0,1)", "start_offset": "uniform(-1,1)"}
    vary = {name: distribution(name, text) for name, text in texts.items()}
    given: dict[str, Any] = {"vary": vary, "runs": 4, "seed": 3, "label": "car", **changes}
    return sweep.Job(STRAIGHT, "pop", popsteer.PopParams(), "kinematic-bicycle", **given)


def row(run: int, error: float, **changes: Any) -> dict[str, Any]:
    """A run with this greatest error after settling, ten times as much before."""
    good = {
        "run": run,
        "seed": 1000 + run,
        "success": True,
        "finished": True,
        "faults": 0,
        "steer_lag": 0.1 * run,
        "start_offset": 0.0,
        "start_yaw": 0.0,
        "time": 20.0,
        "steps": 400,
        ERROR: error,
        "max_abs_cross_track_error": 10.0 * error,
        "settled_mean_abs_cross_track_error": 0.5 * error,
        "settled_max_abs_heading_error": 0.1 * error,
        "rms_steer_rate": 2.0 * error,
    }
    return {**good, **changes}


# Tried in turn, until the field takes one: factors and steps of a number, then plain ones.
_PLAIN = (0.37, 1.3, 0.013, 3.0, 5)


def _candidates(value: Any) -> Iterator[Any]:
    if isinstance(value, bool):
        yield not value
    elif isinstance(value, int):
        yield from (value + 1, value - 1, 7)
    elif isinstance(value, float):
        yield from (0.871 * value, 1.037 * value, value + 0.013, value - 0.013)
    yield from _PLAIN
    yield from (True, False, "other")


def changed(whole: Any, skip: tuple[str, ...] = ()) -> Iterator[tuple[str, Any]]:
    """Give each field's name, and the same value with another one in that field alone."""
    fields = whole.as_dict()
    for name, value in fields.items():
        if name not in skip:
            yield name, _other(whole, name, value)


def _other(whole: Any, name: str, value: Any) -> Any:
    for candidate in _candidates(value):
        try:
            found = whole.replace(**{name: candidate})
        except (ConfigError, TypeError, ValueError):
            continue
        if found.as_dict()[name] != value:
            return found
    raise AssertionError(f"{type(whole).__name__}.{name}: nothing else than {value!r} is taken")


class Twin(NamedTuple):
    """By what the forward case is multiplied."""

    x: float
    y: float
    yaw: float
    speed: float
    steer: float

    def path(self, xy: ArrayLike, speed: ArrayLike | None = None, **options: Any) -> popsteer.Path:
        """Give the path of the twin from the waypoints of the forward case."""
        places = np.asarray(xy, dtype=np.float64) * (self.x, self.y)
        if speed is None and self.speed < 0.0:
            return popsteer.Path(places, reverse=np.ones(len(places), dtype=bool), **options)
        speeds = None if speed is None else self.speed * np.asarray(speed, dtype=np.float64)
        return popsteer.Path(places, speed=speeds, **options)

    def pose(self, x: float, y: float, yaw: float) -> tuple[float, float, float]:
        return self.x * x, self.y * y, self.yaw * yaw

    def columns(self, columns: dict[str, NDArray[np.float64]]) -> dict[str, NDArray[np.float64]]:
        """Give the columns of a log or of records as the twin has them."""
        signs = {**self._asdict(), "cross_track_error": self.steer, "heading_error": self.steer}
        return {name: signs.get(name, 1.0) * values for name, values in columns.items()}


SELF = Twin(1.0, 1.0, 1.0, 1.0, 1.0)
MIRRORED = Twin(1.0, -1.0, -1.0, 1.0, -1.0)
# Along a straight line the heading stays 0: the path leads to -x, and so does the vehicle.
BACKWARDS = Twin(-1.0, 1.0, 1.0, -1.0, 1.0)


RECORDED = Path(__file__).with_name("recorded.json")


def of_figure(figure: Figure) -> dict[str, Any]:
    """Give what a figure of matplotlib has in it, without drawing it."""
    return {
        "size": plain(figure.get_size_inches()),
        "words": [text.get_text() for text in figure.texts if text.get_text()],
        "title": figure.get_suptitle(),
        "legends": [_legend(each) for each in figure.legends],
        "panels": [_panel(panel) for panel in figure.axes],
    }


def _panel(panel: Any) -> dict[str, Any]:
    return {
        "words": [panel.get_title(), panel.get_xlabel(), panel.get_ylabel()],
        "limits": plain([panel.get_xlim(), panel.get_ylim()]),
        "scale": panel.get_yscale(),
        "visible": panel.get_visible(),
        "ticks": _named_ticks(panel),
        "legend": _legend(panel.get_legend()),
        "lines": [_line(line) for line in panel.lines],
        "areas": [_area(each) for each in panel.collections],
    }


def _named_ticks(panel: Any) -> list[str]:
    """Give the names on a panel's axis; not the numbers, which matplotlib chooses."""
    words = [each.get_text() for each in panel.get_yticklabels()]
    return [each for each in words if each[:1].isalpha()]


def _line(line: Any) -> dict[str, Any]:
    names = ("color", "linewidth", "linestyle", "marker", "markersize", "zorder", "drawstyle")
    return {
        "data": plain([line.get_xdata(), line.get_ydata()]),
        **{name: plain(getattr(line, f"get_{name}")()) for name in names},
    }


def _area(area: Any) -> dict[str, Any]:
    # Marks have places; what is filled has an outline.
    filled = not hasattr(area, "get_sizes")
    outline = [path.vertices for path in area.get_paths()] if filled else []
    return {
        "data": plain(np.ma.filled(area.get_offsets(), np.nan)),
        "outline": plain(outline),
        "colours": plain(area.get_facecolor()),
        "sizes": plain(getattr(area, "get_sizes", list)()),
        "linewidth": plain(area.get_linewidth()),
    }


def _legend(legend: Artist | None) -> list[str]:
    return [] if legend is None else [text.get_text() for text in legend.get_texts()]  # type: ignore[attr-defined]


def plain(value: Any) -> Any:
    """Give a value as JSON has it, its numbers with six digits."""
    if isinstance(value, dict):
        return {str(key): plain(each) for key, each in value.items()}
    if isinstance(value, np.ndarray):
        return plain(value.tolist())
    if isinstance(value, list | tuple):
        return [plain(each) for each in value]
    if isinstance(value, float):
        return float(f"{value:.6g}") if math.isfinite(value) else str(value)
    return value.item() if isinstance(value, np.generic) else value


def differences(found: Any, wanted: Any, at: str = "", *, close: float = 1e-5) -> list[str]:
    """Name the places where two values differ, numbers by more than a share of them."""
    if isinstance(found, dict) and isinstance(wanted, dict):
        names = dict.fromkeys([*found, *wanted])
        return [
            each
            for name in names
            for each in differences(found.get(name), wanted.get(name), f"{at}.{name}", close=close)
        ]
    if isinstance(found, list) and isinstance(wanted, list) and len(found) == len(wanted):
        pairs = enumerate(zip(found, wanted, strict=True))
        return [
            each for k, (a, b) in pairs for each in differences(a, b, f"{at}[{k}]", close=close)
        ]
    numbers = (int, float)
    if type(found) in numbers and type(wanted) in numbers:
        same = math.isclose(found, wanted, rel_tol=close, abs_tol=1e-4 * close)
    else:
        same = type(found) is type(wanted) and found == wanted
    return [] if same else [f"{at}: {found!r} for {wanted!r}"]


def recorded() -> dict[str, Any]:
    """Give the documents as they were when they were last looked at, by name."""
    found: dict[str, Any] = json.loads(RECORDED.read_text(encoding="utf-8"))
    return found


def record(documents: Mapping[str, Any]) -> None:
    """Write the documents anew, a line for each."""
    lines = [f"{json.dumps(name)}: {json.dumps(plain(each))}" for name, each in documents.items()]
    RECORDED.write_text("{\n" + ",\n".join(lines) + "\n}\n", encoding="utf-8")
