"""The page of a stability study: margins over the speed, Bode, Nyquist and the answer to a step."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from popsteer.lab.common.names import counted, title_of
from popsteer.lab.report.colours import colours_of, figure, line, log_axis
from popsteer.lab.report.markup import badge, paragraphs, table
from popsteer.lab.report.page import NOWHERE, Origin, Page, tuning, vehicles
from popsteer.lab.stability import Stability
from popsteer.lab.stability.figures import USUAL, middle, responses
from popsteer.lab.stability.table import NOTE, stability_caption, stability_table

_EVERY = 8  # of the frequencies one is drawn: more cannot be told apart


def of_stability(result: Stability, origin: Origin = NOWHERE) -> bytes:
    """Make the page of a stability study; the arguments are as `of_comparison` has them.

    Examples
    --------
    >>> from popsteer.lab import stability
    >>> of_stability(stability.run(["pop"], speeds=[5.0, 10.0])).startswith(b"<!doctype html>")
    True
    """
    wrong = [
        f"{title_of(name, result.margins)} at {speed:g} m/s"
        for name, rows in result.margins.items()
        for speed, found in zip(result.speeds, rows, strict=True)
        if not found.stable
    ]
    loops = len(result.margins) * len(result.speeds)
    head = f"{loops - len(wrong)} of {counted(loops, 'loop')} are stable"
    return Page(
        title=f"Stability of {counted(len(result.margins), 'controller')}",
        lead=stability_caption(result),
        command=origin.command,
        results=badge(head, [f"unstable: {', '.join(wrong)}"] if wrong else [], good=not wrong)
        + table(stability_table(result), "Margins")
        + paragraphs([NOTE]),
        figures=[*_margins(result), *_loops(result)],
        roles=colours_of(result.params),
        sections=[vehicles(("plant", result.vehicle, result.believed)), tuning(origin)],
    ).content()


def _margins(result: Stability) -> list[dict[str, Any]]:
    kinds = (
        ("Gain margin", "gain", 1.0),
        ("Phase margin [deg]", "phase", math.degrees(1.0)),
        ("Dead time that may be added [ms]", "dead_time", 1e3),
    )
    figures = []
    for (title, field, scale), usual in zip(kinds, (*USUAL, None), strict=True):
        traces = []
        for name, rows in result.margins.items():
            values = [scale * getattr(found, field) for found in rows]
            named = title_of(name, result.margins)
            traces.append(line(named, result.speeds, values, f"@{name}", mode="lines+markers"))
        said = "" if usual is None else f" Usual are {usual[0]:g} to {usual[1]:g} (grey)."
        note = f"Over the speed; none where the loop is unstable as it is.{said}"
        up: dict[str, Any] = {"title": {"text": title}}
        if field != "phase":
            finite = [y for trace in traces for y in trace["y"] if y is not None and y > 0.0]
            up = log_axis(title, *((min(finite), max(finite)) if finite else (1.0, 10.0)))
        bands = [] if usual is None else [_band(*usual)]
        figures.append(figure(title, note, traces, "speed [m/s]", up, shapes=bands))
    return figures


def _band(low: float, high: float) -> dict[str, Any]:
    ends = {"xref": "paper", "x0": 0, "x1": 1, "y0": low, "y1": high}
    look = {"fillcolor": "@grid", "opacity": 0.5, "line": {"width": 0}, "layer": "below"}
    return {"type": "rect", **ends, **look}


def _loops(result: Stability) -> list[dict[str, Any]]:
    found = responses(result)
    at = f"{middle(result):g} m/s"
    drawn: list[list[dict[str, Any]]] = [[], [], [], []]
    size, phase, nyquist, step = drawn
    for name, each in found.items():
        title, colour = title_of(name, found), f"@{name}"
        gains, phases = each.crossings()
        frequency, answer = each.frequency[::_EVERY], each.gain[::_EVERY]
        gain = np.abs(answer)
        size.append(line(title, frequency, gain, colour))
        phase.append(line(title, frequency, np.degrees(each.phase[::_EVERY]), colour))
        degrees = [(where, math.degrees(value)) for where, value in gains]
        for traces, marked in ((size, phases), (phase, degrees)):
            across, up = ([place[k] for place in marked] for k in (0, 1))
            traces.append(line(title, across, up, colour, mode="markers", showlegend=False))
        near = gain < 20.0  # at low frequencies it is far off
        nyquist.append(line(title, answer.real[near], answer.imag[near], colour))
        step.append(line(title, each.time, each.offset, colour))
    frequencies = next(iter(found.values())).frequency
    axis = log_axis("frequency [rad/s]", 0.05, frequencies[-1])
    axis["range"] = [math.log10(0.05), math.log10(frequencies[-1])]
    dots = f"The open loop at {at}. Dots: where the"
    circle = np.exp(1j * np.linspace(0.0, math.tau, 91))
    nyquist.append(line("unit circle", circle.real, circle.imag, "@faint", width=0.8))
    near_one = -1.0 + 0.5 * circle
    nyquist.append(line("half from -1", near_one.real, near_one.imag, "@faint", width=0.8))
    high = log_axis("magnitude", 1e-3, 1e2) | {"range": [-3, 2]}
    turned: dict[str, Any] = {"title": {"text": "phase [deg]"}, "range": [-360, 0], "dtick": 90}
    plane: dict[str, Any] = {"title": {"text": "imaginary"}, "range": [-2, 2], "scaleanchor": "x"}
    side: dict[str, Any] = {"title": {"text": "real"}, "range": [-3, 2]}
    moved: dict[str, Any] = {"title": {"text": "offset of the vehicle [m]"}, "range": [-0.2, 1.8]}
    said = "The open loop; outside of the circle around -1 disturbances grow at most twofold."
    return [
        figure("Bode: magnitude", f"{dots} gain margin is read.", size, axis, high),
        figure("Bode: phase", f"{dots} phase margin is read.", phase, axis, turned),
        figure("Nyquist", said, nyquist, side, plane, hovermode="closest"),
        figure("Step", f"The path moves by 1 m at {at}.", step, "time [s]", moved),
    ]
