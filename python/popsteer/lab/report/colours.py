"""The colours of a page, each a pair for a light and for a dark background; its figures."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

from popsteer.lab.common.names import title_of
from popsteer.lab.common.theme import THEMES

Colour = list[str]
"""The colour on a light, and on a dark background."""

_SURFACE = {"light": "#f6f8fa", "dark": "#151b23"}
_ACCENT = {"light": "#0969da", "dark": "#4493f8"}
_RANKED = {
    "light": ("#d55e00", "#0072b2", "#009e73", "#b5589a", "#8a6d00", "#5b21e6", "#882255"),
    "dark": ("#ff8c42", "#56b4e9", "#2fd0a0", "#e79ccb", "#f0e442", "#8163ff", "#ff9da7"),
}


def colours_of(names: Iterable[str]) -> dict[str, Colour]:
    """Give each controller the colours that it has in the figures that are files."""
    names = list(names)
    light, dark = (THEMES[name].colours(names) for name in ("light", "dark"))
    return {name: [light[name], dark[name]] for name in names}


def named(role: str) -> Colour:
    """Give the colours of a field of `popsteer.lab.common.theme.Theme`, or of a controller."""
    return [THEMES[name].colour(role) for name in ("light", "dark")]


def ranked(place: int) -> Colour:
    """Give the colours of what has no name but a place from 0 on, such as the worst run."""
    return [_RANKED[name][place % len(_RANKED[name])] for name in ("light", "dark")]


def style() -> str:
    """Give the colours as custom properties of CSS, which change with the system's setting."""

    def rules(name: str) -> str:
        theme = THEMES[name]
        values = {
            "background": theme.background,
            "surface": _SURFACE[name],
            "text": theme.text,
            "faint": theme.faint,
            "grid": theme.grid,
            "path": theme.path,
            "accent": _ACCENT[name],
            "good": theme.laws["pop"],
            "bad": theme.laws["pid"],
        }
        return " ".join(f"--{key}: {value};" for key, value in values.items())

    return (
        f":root {{ color-scheme: light dark; {rules('light')} }}\n"
        f"@media screen and (prefers-color-scheme: dark) {{ :root {{ {rules('dark')} }} }}\n"
    )


_MANY = 2.5  # decades from which on 2 and 5 are left out


def rounded(values: Iterable[float], digits: int = 4) -> list[float]:
    """Round numbers to as many digits as can be seen, which keeps a page small."""
    return [float(f"{value:.{digits}g}") for value in values]


def log_axis(title: str, low: float, high: float) -> dict[str, Any]:
    """Describe a logarithmic axis for plotly: marks at 1, 2 and 5, or at 1 where there are many."""
    steps = (1,) if math.log10(high / low) > _MANY else (1, 2, 5)
    first, last = math.floor(math.log10(low)), math.ceil(math.log10(high))
    marks = [step * 10.0**power for power in range(first, last + 1) for step in steps]
    marks = [float(f"{mark:.1g}") for mark in marks if 0.999 * low <= mark <= 1.001 * high]
    axis: dict[str, Any] = {"type": "log", "title": {"text": title}}
    if len(marks) > 1:
        axis |= {"tickvals": marks, "ticktext": [f"{mark:g}" for mark in marks]}
    return axis


def figure(
    title: str,
    note: str,
    traces: list[dict[str, Any]],
    x: str | dict[str, Any],
    y: str | dict[str, Any],
    **layout: Any,
) -> dict[str, Any]:
    """Describe a figure for plotly; each axis is a title, or described already."""
    across, up = ({"title": {"text": each}} if isinstance(each, str) else each for each in (x, y))
    layout = {"xaxis": across, "yaxis": up, **layout}
    return {"title": title, "note": note, "traces": traces, "layout": layout}


def line(
    name: str,
    x: Iterable[float],
    y: Iterable[float],
    colour: str,
    *,
    width: float = 1.6,
    shape: str = "linear",
    **more: Any,
) -> dict[str, Any]:
    """Draw a line of some colour, such as ``@pop``; where a number is not finite it breaks."""
    up = [float(f"{value:.5g}") if math.isfinite(value) else None for value in y]
    look = {"color": colour, "width": width, "shape": shape}
    places = {"x": rounded(x, 5), "y": up, "line": look, "marker": {"color": colour}}
    return {"type": "scatter", "mode": "lines", "name": name, **places, **more}


def stairs(
    law: str,
    among: Iterable[str],
    edges: Iterable[float],
    shares: Iterable[float],
    width: float,
    hover: str,
) -> dict[str, Any]:
    """Draw a controller's histogram as a line; a share [%] holds until the next edge."""
    kind = {"type": "scatter", "mode": "lines", "name": title_of(law, among)}
    places = {"x": rounded(edges), "y": [round(float(share), 3) for share in shares]}
    look = {"color": f"@{law}", "shape": "hv", "width": width}
    return {**kind, **places, "line": look, "hovertemplate": hover}


def dots(
    name: str,
    x: Iterable[float],
    y: Iterable[float],
    text: list[str],
    marker: dict[str, Any],
    hover: str,
) -> dict[str, Any]:
    """Draw places, each with a text that `hover` shows."""
    kind = {"type": "scatter", "mode": "markers", "name": name}
    places = {"x": rounded(x), "y": rounded(y), "text": text}
    return {**kind, **places, "marker": marker, "hovertemplate": hover}
