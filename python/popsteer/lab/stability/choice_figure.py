"""Figure of the theory page: offset in a bend against dead-time margin, POP and preview POP."""

from __future__ import annotations

import math
from functools import partial
from typing import TYPE_CHECKING

from matplotlib.figure import Figure

from popsteer._core import PopParams, PreviewPopParams
from popsteer.lab.stability.preview_bend import Choice, choice
from popsteer.lab.stability.table import stability_caption

if TYPE_CHECKING:
    from collections.abc import Mapping

    from matplotlib.axes import Axes

    from popsteer.lab.common.theme import Theme
    from popsteer.lab.stability import Stability

_SPEED, _RADIUS = 15.0, 50.0
_DISTANCES = (1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0)
_COSTS = (0.02, 0.05, 0.1, 0.25, 0.5, 1.0, 2.0)
_POP = "POP, over its lookahead [m]"
_MODELS = {
    "preview POP, over its steer_rate_cost [m s/rad]": (1.0, "o"),
    "preview POP that does not adapt, given a wheelbase 15 % too long": (1.15, "^"),
    "preview POP, 15 % too short (offset to the outside)": (0.85, "v"),
}
_MARKED = {_POP: (1.0, 3.0, 6.0, 9.0), next(iter(_MODELS)): (0.02, 0.25, 2.0)}


def choice_curves(result: Stability) -> dict[str, Choice]:
    """Compute the curves of the figure, each by what it shows.

    There are no curves if the study lacks POP or preview POP.
    """
    pop, preview = result.params.get("pop"), result.params.get("preview-pop")
    if not (isinstance(pop, PopParams) and isinstance(preview, PreviewPopParams)):
        return {}
    vehicle, believed = result.vehicle, result.believed
    bend = partial(choice, vehicle=vehicle, radius=_RADIUS, speed=_SPEED, dt=result.dt)
    curves = {_POP: bend(pop, values=_DISTANCES, believed=believed)}
    for said, (share, _) in _MODELS.items():
        given = believed.replace(turning_wheelbase=share * believed.turning_length(0.0))
        curves[said] = bend(preview, values=_COSTS, believed=given, adapt=None)
    return curves


def choice_figure(result: Stability, curves: Mapping[str, Choice], theme: Theme) -> Figure:
    """Draw offsets in a bend against dead-time margins."""
    figure = Figure(figsize=(8.4, 4.6), layout="constrained")
    panel = figure.subplots()
    for said, found in curves.items():
        law, marker = ("pop", "o") if said == _POP else ("preview-pop", _MODELS[said][1])
        panel.plot(
            [1e3 * each for each in found.dead_times],
            [abs(each) for each in found.offsets],
            f"{marker}-",
            color=theme.laws[law],
            linewidth=1.8 if said in _MARKED else 1.0,
            markersize=5,
            label=said,
        )
        # Beside the steep curve, below the flat one.
        _mark(panel, found, _MARKED.get(said, ()), (8, -4) if law == "pop" else (-5, -14), theme)
    panel.set(xlabel="dead time that may be added [ms]", xlim=(0.0, None), ylim=(-0.08, 1.1))
    panel.set_ylabel("offset in the bend [m]")
    panel.set_title(f"A bend of {_RADIUS:g} m radius at {_SPEED:g} m/s", pad=8)
    panel.legend(fontsize=8.5, loc="upper left")
    figure.suptitle(stability_caption(result), fontsize=9, color=theme.faint)
    return figure


def _mark(
    panel: Axes,
    found: Choice,
    values: tuple[float, ...],
    shift: tuple[int, int],
    theme: Theme,
) -> None:
    """Write some values of the parameter beside their points."""
    for value, dead_time, offset in zip(*found, strict=True):
        if value in values and math.isfinite(dead_time):
            panel.annotate(
                f"{value:g}",
                (1e3 * dead_time, abs(offset)),
                xytext=shift,
                textcoords="offset points",
                fontsize=8.5,
                color=theme.text,
            )
