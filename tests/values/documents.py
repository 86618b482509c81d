"""What a figure or a page draws, as plain values: data, limits, words and looks."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Mapping

    from matplotlib.artist import Artist
    from matplotlib.figure import Figure

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
