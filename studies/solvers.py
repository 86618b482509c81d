"""Times the MPC's quadratic problem by solvers in C, beside calls of daqp and preview POP's step.

    pip download --no-deps --no-binary :all: --dest out/solvers daqp tinympc
    python -m studies.solvers out/solvers    # writes benches/README.md

The folder holds the solvers' sources; they are compiled with the yardsticks of benches/yardsticks.
"""

from __future__ import annotations

import ctypes
import subprocess
import sys
import tarfile
import tempfile
import time
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

import popsteer
from popsteer.lab.opponents.lqr import model, weights
from popsteer.lab.opponents.mpc import Mpc, Weights
from popsteer.lab.suite import suite_car
from popsteer.lab.suite.conditions import CONDITIONS
from popsteer.lab.suite.drive import drive, seed_of
from popsteer.lab.suite.scenarios import SCENARIOS
from studies.layout import ROOT, line, write_blocks

if TYPE_CHECKING:
    from collections.abc import Iterable

    from numpy.typing import NDArray

    from popsteer.lab.opponents import Seen

    Floats = NDArray[np.float64]

STAGES, STAGE = 20, 0.05
PASSES = 3
UNDER = ("as told", "noise")
OWN, CALLED, KEPT, FRESH, TINY, OURS, RATIO = (
    "daqp, its own `solve_time`",
    "daqp, as called from Python",
    "daqp in C, Hessian kept",
    "daqp in C, with a new Hessian",
    "TinyMPC in C++, its cache kept",
    "preview POP's whole step, as called from Python",
    "... over daqp in C, Hessian kept",
)
# TinyMPC's: with larger tolerances, or fewer passes, its first moves are others.
RHO, TOLERANCE, MOST = 0.09, 1e-6, 1000
OPTIONS = ("-O3", "-march=native", "-DNDEBUG", "-shared", "-fPIC", "-w")


class Tap:
    """Keeps what daqp's model is given."""

    def __init__(self, solver: Any) -> None:
        self.solver, self.solve = solver, solver.solve

    def update(self, **given: Any) -> None:
        """Take what changes."""
        self.given = given
        self.solver.update(**given)


class Recorded(Mpc):
    """The MPC; keeps its problems, condensed and by stages, and what its calls take."""

    def __init__(self, path: popsteer.Path, vehicle: popsteer.Vehicle) -> None:
        self.problems: list[dict[str, Any]] = []
        super().__init__(path, vehicle, Weights())

    def _condense(self, seen: Seen, rate: float) -> Floats:
        self.hessian = super()._condense(seen, rate)
        self.model = model(seen.speed, seen.length, self.vehicle.steer_lag, rate, STAGE)
        return self.hessian

    def step(self, x: float, y: float, yaw: float, speed: float, dt: float, /) -> float:
        """Steer; the first problem is lost."""
        self.update(x, y, yaw, speed, dt)
        begun = time.perf_counter()
        steer = self.solve()
        called = time.perf_counter() - begun
        if isinstance(self._solver, Tap):
            own = {OWN: self.said["solve_time"], CALLED: called}
            self.problems.append(self.problem(self._solver.given) | own)
        else:
            self._solver = Tap(self._solver)
        return steer

    def problem(self, given: dict[str, Any]) -> dict[str, Any]:
        """Give the problem of this step."""
        seen = self._seen
        bends = self.observer.curvature(seen, seen.speed * STAGE * np.arange(STAGES + 1.0))
        reference = np.arctan(seen.length * bends)
        wanted = np.zeros((STAGES + 1, 4))
        wanted[1:] = np.column_stack((0.0 * bends, -seen.slope * bends, reference, reference))
        # What the path takes off is the same for every plan: it moves what is wanted.
        wanted[1:] += (self._drift @ reference).reshape(STAGES, 4)
        dynamics, inputs = self.model
        return {
            "fresh": given["H"] is not None or not self.problems,
            "hessian": self.hessian,
            "gradient": given["f"],
            "upper": given["bupper"],
            "lower": given["blower"],
            "dynamics": dynamics,
            "inputs": inputs,
            "start": [seen.error, seen.heading, seen.wheel, self._before],
            "wanted": wanted,
            "before": self._before,
        }


class Timed:
    """Preview POP; keeps what its steps take."""

    def __init__(self, path: popsteer.Path, vehicle: popsteer.Vehicle) -> None:
        self.law, self.times = popsteer.PreviewPop(path, vehicle), list[float]()

    def step(self, x: float, y: float, yaw: float, speed: float, dt: float, /) -> float:
        """Steer."""
        begun = time.perf_counter()
        steer = self.law.steer(x, y, yaw, speed, dt)
        self.times.append(time.perf_counter() - begun)
        return steer


def record(condition: str, scenarios: Iterable[str] = tuple(SCENARIOS)) -> dict[str, Floats]:
    """Drive scenarios by both, each in its own loop: problems, and times of calls [s]."""
    problems: list[dict[str, Any]] = []
    steps: list[float] = []
    for name in scenarios:
        for kind in (Recorded, Timed):
            made: list[Any] = []
            make = partial(_keep, made, kind)
            found = drive(SCENARIOS[name], CONDITIONS[condition], suite_car(), make, seed_of(name))
            if found.traceback:
                raise SystemExit(found.traceback)
            if kind is Timed:
                steps += made[0].times
            else:
                problems += made[0].problems
    fields = {name: np.array([each[name] for each in problems], float) for name in problems[0]}
    return fields | {OURS: np.array(steps)}


def _keep(made: list[Any], kind: Any, path: popsteer.Path, car: popsteer.Vehicle) -> Any:
    made.append(kind(path, car))
    return made[-1]


def build(folder: Path, name: str, source: str, include: str, sources: str) -> Any:
    """Compile a yardstick with its solver's sources."""
    found = sorted(folder.glob(f"{name}-*.tar.gz"))
    if not found:
        raise SystemExit(f"{folder}: holds no {name}-*.tar.gz; `pydoc studies.solvers` says whence")
    with tempfile.TemporaryDirectory() as place, tarfile.open(found[-1]) as packed:
        packed.extractall(place, filter="data")
        (root,) = (each for each in Path(place).iterdir() if each.is_dir())
        yardstick = ROOT / "benches" / "yardsticks" / source
        compiler = "c++" if source.endswith("cpp") else "cc"
        includes = [f"-I{root / include}", *(f"-I{each}" for each in root.glob("*/*/include/*"))]
        library = root / "yardstick.so"
        files = map(str, [yardstick, *sorted(root.glob(sources))])
        command = [compiler, *OPTIONS, *includes, *files, "-lm"]
        subprocess.run([*command, "-o", str(library)], check=True)
        return ctypes.CDLL(str(library)).solve_all


def call(solve: Any, count: int, *given: Any) -> tuple[Floats, Floats]:
    """Call it: first moves, and times [s]."""
    moves, seconds = np.zeros(count), np.zeros(count)
    kept = [np.ascontiguousarray(each) if isinstance(each, np.ndarray) else each for each in given]
    as_c = [
        each.ctypes.data_as(ctypes.c_void_p)
        if isinstance(each, np.ndarray)
        else (ctypes.c_double(each) if isinstance(each, float) else each)
        for each in (*kept, moves, seconds)
    ]
    if solve(count, *as_c) < 0:
        raise SystemExit("a problem was not solved")
    return moves, seconds


def by_daqp(solve: Any, of: dict[str, Floats]) -> tuple[Floats, Floats]:
    """Solve a drive's problems by daqp."""
    fresh = of["fresh"].astype(np.int32)
    sums = np.tril(np.ones((STAGES, STAGES)))
    names = ("gradient", "upper", "lower")
    given = (sums, of["hessian"], fresh, *(of[name] for name in names))
    return call(solve, len(fresh), STAGES, STAGES, *given)


def by_tinympc(solve: Any, of: dict[str, Floats]) -> tuple[Floats, Floats]:
    """Solve them by TinyMPC."""
    fresh = of["fresh"].astype(np.int32)
    change = of["upper"][:, :STAGES]
    low, high = (of[name][:, STAGES:] + of["before"][:, None] for name in ("lower", "upper"))
    q, r = weights(suite_car().vehicle.wheelbase, **asdict(Weights()))
    dynamics = (of["dynamics"], of["inputs"], np.diag(q), float(r[0, 0]))
    given = (*dynamics, RHO, TOLERANCE, MOST, fresh, of["start"], of["wanted"])
    return call(solve, len(fresh), STAGES, *given, change, low, high)


def main() -> None:
    """Time them; write the page."""
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else "out/solvers")
    by_c = build(folder, "daqp", "qp_daqp.c", "csrc/include", "csrc/src/*.c")
    tiny = build(
        folder,
        "tinympc",
        "qp_tinympc.cpp",
        "tinympc/TinyMPC/src",
        "tinympc/TinyMPC/src/tinympc/[art]*.cpp",
    )
    rows: dict[str, list[str]] = {}
    apart: dict[str, float] = {}
    for condition in UNDER:
        times: dict[str, list[Floats]] = {}
        for _ in range(PASSES):
            of = record(condition)
            fresh = of["fresh"] > 0.0
            found = {name: of[name] for name in (OWN, CALLED)}
            exact, seconds = by_daqp(by_c, of)
            found |= {KEPT: seconds[~fresh], FRESH: seconds[fresh]}
            moves, seconds = by_tinympc(tiny, of)
            found[TINY] = seconds[~fresh]
            apart[condition] = 1e3 * float(np.quantile(np.abs(moves - exact), 0.95))
            for name, each in (found | {OURS: of[OURS]}).items():
                times.setdefault(name, []).append(each)
        for name, several in times.items():
            quantiles = 1e6 * np.quantile(np.concatenate(several), (0.5, 0.99))
            rows.setdefault(name, [name]).extend(f"{value:.2f}" for value in quantiles)
    pairs = zip(rows[OURS][1:], rows[KEPT][1:], strict=True)
    rows[RATIO] = [RATIO, *(f"{float(ours) / float(daqp):.1f}" for ours, daqp in pairs)]
    said = " and ".join(f"{each:.2g}" for each in apart.values())
    rows[TINY][0] += f"; 95 % of its first moves within {said} mrad of daqp's"
    lines = [
        line("", "as told: p50 [µs]", "p99", "in noise: p50", "p99"),
        "|---|--:|--:|--:|--:|",
        *(line(*row) for row in rows.values()),
    ]
    print("\n".join(lines))
    write_blocks(ROOT / "benches" / "README.md", {"solvers": "\n".join(lines)})


if __name__ == "__main__":
    main()
