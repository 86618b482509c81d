"""The tables of docs/choose.md and docs/paper.md."""

from __future__ import annotations

import itertools
import math
import re
import statistics
from typing import TYPE_CHECKING

from popsteer import (
    AdaptParams,
    CoupledLongitudinal,
    Pid,
    PidParams,
    controllers,
    lab,
    presets,
    sim,
)
from popsteer.lab.common.names import title_of
from popsteer.sim import CarlaIdentified
from studies.layout import DOCS, cells, course, line, table
from studies.sizing import job

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

CHOICES = ("preview-pop", "pure-pursuit", "stanley", "pop", "pid", "mpc")
# Its wheels turn at once, which is not every controller's case.
BICYCLE = "kinematic-bicycle"
# Bounds of what counts as reproduced; tests/closed_loop/test_acceptance.py has them, too.
CROSS_TRACK, HEADING = 0.05, 0.10


def matrix() -> tuple[dict[str, dict[tuple[str, str], list[float]]], dict[str, float]]:
    """The record of `make matrix`: by title the errors by plant and track, and the steps [µs].

    The errors are those at the point that the controller tracks, and at the rear axle.
    """
    block = (DOCS / "choose.md").read_text(encoding="utf-8").partition("<!-- matrix: begin")[2]
    found: dict[str, dict[tuple[str, str], list[float]]] = {}
    steps: dict[str, list[float]] = {}
    for part in block.partition("<!-- matrix: end")[0].split("\n\n")[:-1]:
        head, _, *rows = (cells(row) for row in re.findall(r"^\|.*\|$", part, re.MULTILINE))
        track, _, *plants, _ = head
        for title, _, *errors, step in rows:
            both = [[float(one.strip("()")) for one in each.split(" / ")] for each in errors]
            keys = ((plant, track) for plant in plants)
            found.setdefault(title, {}).update(zip(keys, both, strict=True))
            steps.setdefault(title, []).append(float(step))
    return found, {title: statistics.median(own) for title, own in steps.items()}


def _loop(title: str, row: str) -> str:
    page = (DOCS / "loop.md").read_text(encoding="utf-8")
    head = page.partition("<!-- table: cars loop -->\n")[2].partition("\n")[0]
    titles = [each.lower() for each in cells(head)]
    if title.lower() not in titles:
        return "-"
    found = next(cells(each) for each in table("loop.md", "cars loop") if row in each)
    return found[titles.index(title.lower())].partition(" / ")[0]


def _at_both(of: Callable[[Iterable[float]], float], errors: Iterable[list[float]]) -> str:
    return " / ".join(f"{of(each):.3f}" for each in zip(*errors, strict=True))


def _margins(title: str) -> list[str]:
    rows = {each[0]: each for each in map(cells, table("theory.md", "margins"))}
    # Each speed has two columns; the first is computed.
    return [f"{float(rows[title][at]):.0f}" for at in (3, 7)] if title in rows else ["-", "-"]


def choose_lines() -> list[str]:
    """What each controller does on the records of other pages."""
    record, steps = matrix()
    lines = []
    for name in CHOICES:
        title = title_of(name)
        errors = record[title]
        of_bicycle = [error for (plant, _), error in errors.items() if plant == BICYCLE]
        others = [error for (plant, _), error in errors.items() if plant != BICYCLE]
        lines.append(
            line(
                title,
                _at_both(statistics.median, errors.values()),
                _at_both(max, others),
                _at_both(max, of_bicycle),
                _loop(title, "as it is"),
                _loop(title, "localisation noise"),
                *_margins(title),
                f"{steps[title]:.2f}",
            )
        )
    return lines


def adapting_lines() -> list[str]:
    """1,000 runs of preview POP with and without estimation, each pair of the same draws."""
    error = "settled_mean_abs_cross_track_error"
    lines = []
    for case, vary, speed in (
        ("the defaults of `popsteer sweep`", {}, None),
        ("... at 10 m/s", {}, 10.0),
        ("... the dead time up to 0.2 s", {"dead_time": "uniform(0,0.2)"}, 10.0),
        ("... an offset of 3° (standard deviation)", {"steer_offset": "normal(0,0.05)"}, 10.0),
    ):
        with_it, without = (
            lab.sweep.run(job(CarlaIdentified(), 1000, vary, adapt=adapt, constant_speed=speed))
            for adapt in (AdaptParams(), None)
        )
        pairs = list(zip(with_it, without, strict=True))
        times = statistics.quantiles((a[error] / b[error] for a, b in pairs), n=20)
        lines.append(
            line(
                case,
                f"{sum(a['success'] for a, _ in pairs):,}",
                f"{sum(b['success'] for _, b in pairs):,}",
                str(sum(a["success"] and not b["success"] for a, b in pairs)),
                str(sum(b["success"] and not a["success"] for a, b in pairs)),
                f"{times[9]:.2f}",
                f"{times[0]:.2f} to {times[-1]:.2f}",
            )
        )
    return lines


def paper_lines() -> list[str]:
    """The paper's table, driven anew on the authors' track."""
    path, _ = course("authors")
    driven = lab.compare.paper.run(path)
    lines = []
    for name, run in driven.runs.items():
        paper, metrics = lab.compare.paper.PAPER[name], run.metrics
        found = (metrics.mean_abs_cross_track_error, metrics.mean_abs_heading_error)
        wanted = (paper.mean_abs_cross_track_error, paper.mean_abs_heading_error)
        apart = [abs(a / b - 1.0) for a, b in zip(found, wanted, strict=True)]
        reproduced = apart[0] <= CROSS_TRACK and apart[1] <= HEADING
        shown = [f"{cell:.4f}" for pair in zip(found, wanted, strict=True) for cell in pair]
        lines.append(line(controllers.get(name).title, *shown, "yes" if reproduced else "no"))
    return lines


class Reading:
    """A PID whose first derivative may be that from no error."""

    def __init__(self, law: Pid, *, kicks: bool) -> None:
        self.law, self.kicks, self.tracked_point = law, kicks, law.tracked_point
        self.reset()

    def reset(self) -> None:
        """Forget the steps taken so far."""
        self.law.reset()
        if self.kicks:
            state = self.law.state
            self.law.state = state.replace(law=state.law.replace(previous_error=0.0))

    def step(self, x: float, y: float, yaw: float, speed: float, dt: float, /) -> float:
        """Steer."""
        return self.law.steer(x, y, yaw, speed, dt)


def pid_lines(most: int = 8) -> list[str]:
    """The readings of the paper's PID that come closest to its row."""
    path, _ = course("authors")
    plant, text = CarlaIdentified(), presets.get("pid", "paper")
    assert isinstance(text, PidParams)
    car, paper = plant.vehicle, lab.compare.paper.PAPER["pid"]
    points = {"front axle": car.rear_axle + car.wheelbase, "pose": 0.0, "rear axle": car.rear_axle}
    found: list[tuple[float, str]] = []
    for (point, ahead), (kp, kd), with_dt, delay, kicks in itertools.product(
        points.items(), ((0.25, 0.2), (0.12, 0.48)), (True, False), (0.0, 0.05, 0.1), (False, True)
    ):
        # It tracks what it takes for the front axle.
        told = car.replace(rear_axle=ahead - car.wheelbase, no_slip_point=None)
        params = text.replace(kp=kp, kd=kd, integral_with_dt=with_dt)
        metrics = sim.run(
            Reading(Pid(path, told, params, adapt=None), kicks=kicks),
            plant.replace(vehicle=car.replace(dead_time=delay)),
            path=path,
            start=lab.compare.paper.START,
            start_at="front",
            longitudinal=CoupledLongitudinal(),
        ).metrics
        error, heading = metrics.mean_abs_cross_track_error, metrics.mean_abs_heading_error
        off = (error / paper.mean_abs_cross_track_error, heading / paper.mean_abs_heading_error)
        furthest = max(abs(each - 1.0) for each in off)
        row = line(
            f"{kp:g}, {params.ki:g}, {kd:g}",
            "with Δt" if with_dt else "without Δt",
            "from 0" if kicks else "none",
            point,
            f"{1e3 * delay:.0f}",
            f"{error:.4f}",
            f"{heading:.4f}",
            f"{math.degrees(metrics.max_abs_steer):.0f}",
            f"{100.0 * furthest:.0f} %",
        )
        found.append((furthest, row))
    return [row for _, row in sorted(found)[:most]]
