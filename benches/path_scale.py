"""What a path costs as it grows, from a thousand waypoints to ten million.

    python benches/path_scale.py                    # print the table, draw the figure
    python benches/path_scale.py --json F           # write the rows to F besides
    python benches/path_scale.py --largest 100000   # stop there: a quick look

The path is a field driven up and down: wiggly rows of 1,000 m with a waypoint each metre, 10 m
apart, a half circle from each to the next.

- A step is `Pop.steer` at 10 m/s and 20 Hz, in batches of 32 calls along a row in the second half
  of the path, the same states relative to the row at each length. Each drive goes along another
  row, as long as there are any: steady driving meets new waypoints, which are in no cache yet. A
  path of 1,000 waypoints is one row, and in the cache. The lengths take turns, batch by batch,
  forwards and backwards.
- Steps that look for the vehicle on the whole path are timed one by one, the reading of the clock
  included, at places drawn from the whole path with any heading. The first step and the first
  after a change of the path are up to 50 m beside it; the latter follows at the same place, which
  is in a cache then. A lost vehicle is 31 to 50 m outside the field, with its last place anywhere
  on the path. A relocalisation is `Pop.relocalise`, up to 3 m beside the path.
- Far off is the centre of a circle of as many waypoints: there a step ends with its budget.
- Memory is the difference of resident pages in a process of its own; under a million waypoints it
  drowns in what else the process does. The test rust/core/tests/path_memory.rs counts it exactly.
"""

from __future__ import annotations

import argparse
import ctypes
import gc
import json
import os
import statistics
import sys
from functools import partial
from multiprocessing import get_context
from pathlib import Path
from time import perf_counter_ns
from typing import TYPE_CHECKING, Any

import numpy as np

import popsteer
from popsteer.files import write_bytes_atomic, write_text_atomic
from popsteer.lab.common.layout import this_machine

if TYPE_CHECKING:
    from collections.abc import Callable

    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    from popsteer.lab.common.theme import Theme

SIZES = (1_000, 10_000, 100_000, 1_000_000, 10_000_000)
FIGURES = Path(__file__).resolve().parent / "figures"
ROW, TURN = 1000, 16
BATCH, DT, SPEED = 32, 0.05, 10.0
STEP = "step p50 [ns]"
STEPS = (STEP, "step p99 of batches [ns]", "step, to 1,000")
SEARCHES = ("first step", "step on another path", "step while lost", "relocalise")
CONSTRUCTION = "construction [ns/waypoint]"
MEMORY = "memory [bytes/waypoint]"


def field(count: int) -> NDArray[np.float64]:
    """Make so many waypoints, shape (N, 2) [m]."""
    row, place = np.divmod(np.arange(count), ROW + TURN)
    ahead = np.where(row % 2, np.pi, 0.0)
    wiggle = 0.3 * np.sin(np.arange(ROW + TURN) * (2.0 * np.pi / 50.0))[place]
    turn = np.where(row % 2, -np.pi, np.pi) * (place - ROW + 0.5) / TURN
    heading = ahead + np.where(place < ROW, wiggle, turn)
    xy = np.zeros((count, 2))
    np.cumsum(np.cos(heading[:-1]), out=xy[1:, 0])
    np.cumsum(np.sin(heading[:-1]), out=xy[1:, 1])
    return xy


class RowRunner:
    """Steady driving on one path, row after row; the times of its batches [ns a step]."""

    def __init__(self, path: popsteer.Path, xy: NDArray[np.float64]) -> None:
        self.law = popsteer.Pop(path)
        self.times: list[float] = []
        rows = len(xy) // (ROW + TURN)
        # Every other one: they lead the same way.
        self._rows = range(rows // 4 * 2, max(rows, 1), 2)
        self._xy = xy
        self._states = np.empty((0, 4))

    def begin(self, drive: int) -> int:
        """Go to a row, the controller's place with it; give the number of batches in it."""
        first = (ROW + TURN) * self._rows[drive % len(self._rows)]
        along = np.arange(100.0, 900.0, SPEED * DT)
        whole = along.astype(int)
        here, there = self._xy[first + whole], self._xy[first + whole + 1]
        ahead = there - here
        heading = np.arctan2(ahead[:, 1], ahead[:, 0])
        aside = 0.2 * np.sin(along / 7.0)
        self._states = np.column_stack(
            (
                here + ahead * (along - whole)[:, None]
                + aside[:, None] * np.column_stack((-ahead[:, 1], ahead[:, 0])),
                heading + 0.05 * np.sin(along / 11.0),
                np.full_like(along, SPEED),
            )
        )  # fmt: skip
        self.law.reset()
        self.law.relocalise(*self._states[0, :3].tolist())
        return len(self._states) // BATCH

    def batch(self, number: int) -> None:
        """Drive one batch; the first of a row, after the jump, does not count."""
        states = self._states[BATCH * number : BATCH * (number + 1)].tolist()
        call, dt = self.law.steer, DT
        begin = perf_counter_ns()
        for x, y, yaw, speed in states:
            call(x, y, yaw, speed, dt)
        elapsed = perf_counter_ns() - begin
        if number > 0:
            self.times.append(elapsed / BATCH)


def time_steps(drives: list[RowRunner], repeats: int) -> None:
    """Drive on all paths by turns."""
    for repeat in range(repeats):
        batches = min([drive.begin(repeat) for drive in drives])
        for number in range(batches):
            for drive in drives if (number + repeat) % 2 else reversed(drives):
                drive.batch(number)


def time_of(call: Callable[[], object]) -> int:
    """How long a call takes [ns]."""
    begin = perf_counter_ns()
    call()
    return perf_counter_ns() - begin


def places(xy: NDArray[np.float64], count: int, far: float) -> list[list[float]]:
    """Draw poses up to so far beside the path, anywhere along it and with any heading."""
    rng = np.random.default_rng(3)
    at = xy[rng.integers(0, len(xy), count)]
    way, yaw = rng.uniform(-np.pi, np.pi, (2, count))
    aside = rng.uniform(0.0, far, count)[:, None] * np.column_stack((np.cos(way), np.sin(way)))
    poses: list[list[float]] = np.column_stack((at + aside, yaw)).tolist()
    return poses


def places_outside(xy: NDArray[np.float64], count: int) -> list[list[float]]:
    """Draw poses 31 to 50 m outside the field, beside the ends of its rows."""
    rng = np.random.default_rng(5)
    row = rng.integers(0, max(len(xy) // (ROW + TURN), 1), count)
    at = xy[np.minimum(row * (ROW + TURN) + ROW + TURN // 2, len(xy) - 1)]
    out = np.where(row % 2, -1.0, 1.0) * rng.uniform(31.0, 50.0, count)
    yaw = rng.uniform(-np.pi, np.pi, count)
    poses: list[list[float]] = np.column_stack((at[:, 0] + out, at[:, 1], yaw)).tolist()
    return poses


def time_searches(
    law: popsteer.Pop, path: popsteer.Path, xy: NDArray[np.float64], count: int
) -> dict[str, list[int]]:
    """Look for the vehicle on the whole path, in every way in which a step does [ns]."""
    times: dict[str, list[int]] = {name: [] for name in SEARCHES}
    other = popsteer.Path([(0.0, 0.0), (1.0, 0.0)])
    for x, y, yaw in places(xy, count, 50.0):
        law.reset()
        times["first step"].append(time_of(partial(law.steer, x, y, yaw, SPEED, DT)))
        law.set_path(other)
        law.set_path(path)
        times["step on another path"].append(time_of(partial(law.steer, x, y, yaw, SPEED, DT)))
    for k, (x, y, yaw) in enumerate(places_outside(xy, count)):
        last_x, last_y = xy[7919 * k % len(xy)].tolist()
        law.relocalise(last_x, last_y, 0.0)
        # As a step leaves it: a place that is known.
        before = law.state.replace(place=law.state.place.replace(lost=False))
        law.state = before
        elapsed = time_of(partial(law.steer, x, y, yaw, SPEED, DT))
        law.state = before
        if popsteer.Status.OFF_PATH in law.step(x, y, yaw, SPEED, DT).status:
            times["step while lost"].append(elapsed)
    for pose in places(xy, count, 3.0):
        times["relocalise"].append(time_of(partial(law.relocalise, *pose)))
    return times


def time_far_off(count: int) -> float:
    """Step at the centre of a circle [us]."""
    angle = np.arange(count) * (2.0 * np.pi / count)
    radius = count / (2.0 * np.pi)
    path = popsteer.Path(radius * np.column_stack((np.cos(angle), np.sin(angle))), closed=True)
    law = popsteer.Pop(path)
    times = [time_of(partial(law.steer, 0.0, 0.0, 0.1 * k, SPEED, DT)) for k in range(200)]
    return statistics.median(times[1:]) / 1e3


def time_construction(xy: NDArray[np.float64]) -> tuple[popsteer.Path, float]:
    """Make the path, with its index; give the time of it [ns a waypoint]."""
    times = []
    for _ in range(3 if len(xy) > 100_000 else 15):
        begin = perf_counter_ns()
        path = popsteer.Path(xy)
        times.append(perf_counter_ns() - begin)
    return path, statistics.median(times) / len(xy)


def resident() -> int:
    """Memory of this process [bytes], after all that is free has gone back to the system."""
    gc.collect()
    ctypes.CDLL(None).malloc_trim(0)
    pages = Path("/proc/self/statm").read_text(encoding="ascii").split()[1]
    return int(pages) * os.sysconf("SC_PAGESIZE")


def held(count: int) -> float:
    """Measure what a path and its index hold [bytes a waypoint], in a process of its own."""
    popsteer.Path(field(1000))
    xy, speed = field(count), np.ones(count)
    before = resident()
    path = popsteer.Path(xy, speed=speed)
    return (resident() - before) / len(path)


def memory(count: int) -> float | None:
    """Give what the path with speeds and its index hold, where it can be told."""
    if count < 1_000_000 or not sys.platform.startswith("linux"):
        return None
    with get_context("spawn").Pool(1) as pool:
        return pool.apply(held, (count,))


def measure(sizes: list[int], repeats: int) -> list[dict[str, Any]]:
    """Measure at each length; one row of the table each."""
    rows: list[dict[str, Any]] = []
    drives: list[RowRunner] = []
    for count in sizes:
        xy = field(count)
        of_path = memory(count)
        path, construction = time_construction(xy)
        drives.append(RowRunner(path, xy))
        row = {"waypoints": count, CONSTRUCTION: construction, MEMORY: of_path}
        row |= dict.fromkeys(STEPS, 0.0)  # their place in the table; they are timed together
        for name, times in time_searches(drives[-1].law, path, xy, 5000).items():
            for percent in (50, 99):
                row[f"{name} p{percent} [us]"] = float(np.percentile(times, percent)) / 1e3
        row["step far off p50 [us]"] = time_far_off(count)
        rows.append(row)
    time_steps(drives, 2)
    for drive in drives:
        drive.times.clear()
    gc.disable()
    time_steps(drives, repeats)
    gc.enable()
    medians = [statistics.median(drive.times) for drive in drives]
    for row, drive, median in zip(rows, drives, medians, strict=True):
        late = float(np.percentile(drive.times, 99))
        row.update(zip(STEPS, (median, late, median / medians[0]), strict=True))
    return rows


def table(rows: list[dict[str, Any]]) -> str:
    """Lay the rows out, quantities downwards."""
    return "\n".join(
        f"{name:28}" + "".join(f"{text(row[name]):>12}" for row in rows) for name in rows[0]
    )


def text(value: float | None) -> str:
    """Write a quantity of the table."""
    if value is None:
        return "-"
    return f"{value:,}" if isinstance(value, int) else f"{value:,.4g}"


def draw(rows: list[dict[str, Any]], on: str, theme: Theme) -> Figure:
    """Draw the figure."""
    from matplotlib.figure import Figure

    blue, orange, green = (theme.laws[name] for name in ("pop", "pid", "pure-pursuit"))
    counts = [row["waypoints"] for row in rows]
    figure = Figure(figsize=(10.0, 6.8), layout="constrained")
    (step, jump), (times, memories) = figure.subplots(2, 2)
    panels: list[tuple[Any, str, str, list[tuple[str, str, str]]]] = [
        (step, "A step of POP", "time [ns]", [(STEP, "p50, from Python", blue)]),
        (jump, "A step that looks on the whole path", "time [µs]",
         [("first step p50 [us]", "first step, p50", blue),
          ("first step p99 [us]", "first step, p99", orange)]),
        (times, "Making it", "time [ns/waypoint]", [(CONSTRUCTION, "construction", blue)]),
        (memories, "Memory", "memory [bytes/waypoint]",
         [(MEMORY, "path with speeds, and index", blue)]),
    ]  # fmt: skip
    first = rows[0][STEP]
    step.axhspan(first, 1.2 * first, color=green, alpha=0.12, lw=0)
    step.axhline(1.2 * first, color=green, lw=1.0, ls="--", label="20 % over 1,000 waypoints")
    jump.axhline(20.0, color=green, lw=1.0, ls="--", label="limit, 20 µs")
    memories.axhline(32.0, color=green, lw=1.0, ls="--", label="without the index, 32 bytes")
    for axes, title, unit, lines in panels:
        for name, label, colour in lines:
            values = [np.nan if row[name] is None else row[name] for row in rows]
            axes.plot(counts, values, "o-", color=colour, label=label)
        top = max(axes.get_ylim()[1], 0.0)
        axes.set(title=title, ylabel=unit, xlabel="waypoints", xscale="log", ylim=(0, 1.3 * top))
        axes.set_xlim(counts[0] / 1.6, counts[-1] * 1.6)
        axes.legend(loc="upper left")
    figure.suptitle("What a path costs as it grows", fontsize=14, fontweight="bold")
    figure.supxlabel(on, fontsize=8, color=theme.faint)
    return figure


def main() -> None:
    """Measure, print, write, draw."""
    parser = argparse.ArgumentParser(description="Measure what a path costs as it grows.")
    parser.add_argument("--json", type=Path, metavar="FILE", help="where to write the rows")
    parser.add_argument("--largest", type=int, default=SIZES[-1], metavar="N", help="stop there")
    parser.add_argument("--drives", type=int, default=200, help="drives on each path")
    arguments = parser.parse_args()
    if popsteer.build_profile != "release":
        raise SystemExit("a debug build of popsteer is not worth measuring")
    rows = measure([size for size in SIZES if size <= arguments.largest], arguments.drives)
    machine = this_machine()
    print(table(rows))
    if arguments.json:
        document = json.dumps({"rows": rows, "machine": machine}, indent=2)
        write_text_atomic(arguments.json, document + "\n")
    if arguments.largest >= SIZES[-1]:
        from popsteer.lab.common.draw import drawn
        from popsteer.lab.common.theme import THEMES

        make = partial(draw, rows, f"{machine['cpu']}, {machine['python']}")
        for kind, content in drawn(make, THEMES["light"]).items():
            write_bytes_atomic(FIGURES / f"path_scale.{kind}", content)


if __name__ == "__main__":
    main()
