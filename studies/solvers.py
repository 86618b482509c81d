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
from dataclasses import asdict, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

import popsteer
from popsteer._core import _path_headings
from popsteer.lab.opponents.lqr import model, weights
from popsteer.lab.opponents.mpc import Mpc, Weights
from popsteer.lab.opponents.observer import SMOOTHING, Ahead
from popsteer.lab.suite import suite_car
from popsteer.lab.suite.drive import drive, seed_of
from popsteer.lab.suite.scenarios import CONDITIONS, SCENARIOS
from studies.layout import ROOT, line, write_blocks

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from numpy.typing import NDArray

    from popsteer.lab.opponents import Seen

    Floats = NDArray[np.float64]

STAGES, STAGE = 20, 0.05
PASSES = 5
ASIDE = "aside"
UNDER = ("as told", "noise", ASIDE)
FORWARD = tuple(name for name in SCENARIOS if name != "parking-bay")
OFFSETS = (-3.0, -2.0, -1.0, -0.5, 0.5, 1.0, 2.0, 3.0)
"""How far beside a straight it begins where it begins aside [m]."""
OWN, CALLED, KEPT, FRESH, TINY, WHOLE, WHOLE_KEPT, WHOLE_FRESH, OURS, BARE = (
    "daqp, its own `solve_time`",
    "daqp, as called from Python",
    "daqp in C, Hessian kept",
    "daqp in C, with a new Hessian",
    "TinyMPC in C++, its cache kept",
    "the whole MPC in C",
    "... where it keeps its Hessian",
    "... with a new one",
    "preview POP's whole step, called from Python",
    "... without estimates and faults",
)
RATIOS = {
    "preview POP : daqp in C, Hessian kept": (OURS, KEPT),
    "preview POP : the whole MPC in C": (OURS, WHOLE),
    "... where that keeps its Hessian": (OURS, WHOLE_KEPT),
    "preview POP without estimates and faults : the whole MPC in C": (BARE, WHOLE),
}
AGREE = 1e-9
"""How far the commands of the MPC in C may be from those of the one in Python [rad]."""
# TinyMPC's: with larger tolerances, or fewer passes, its first moves are others.
RHO, TOLERANCE, MOST = 0.03, 1e-6, 10_000
DAQP = ("csrc/include", "csrc/src/*.c")
TINYMPC = ("tinympc/TinyMPC/src", "tinympc/TinyMPC/src/tinympc/[art]*.cpp")
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
    """The MPC without estimates; keeps its problems, condensed and by stages."""

    def __init__(self, path: popsteer.Path, vehicle: popsteer.Vehicle) -> None:
        self.problems: list[dict[str, Any]] = []
        super().__init__(path, vehicle, Weights())

    def reset(self) -> None:
        """Forget the steps taken so far."""
        super().reset()
        self.told = Ahead(self.path, self.vehicle).path
        self.observer.eye = popsteer.PreviewPop(self.told, self.vehicle, adapt=None)

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
        far = 0.5 * self.vehicle.wheelbase  # as the MPC bounds it
        error = min(max(seen.error, -far), far)
        return {
            "fresh": given["H"] is not None or not self.problems,
            "hessian": self.hessian,
            "gradient": given["f"],
            "upper": given["bupper"],
            "lower": given["blower"],
            "dynamics": dynamics,
            "inputs": inputs,
            "start": [error, seen.heading, seen.wheel, self._before],
            "wanted": wanted,
            "before": self._before,
        }


class Course(NamedTuple):
    """What a controller saw and commanded in its own loop."""

    path: popsteer.Path
    car: popsteer.Vehicle
    poses: Floats
    """Of the car's centre [m, m, rad], and speeds [m/s]."""
    commands: Floats
    aside: bool
    """Whether only those farther than a decimetre from the path, which is the x axis, count."""

    @property
    def counts(self) -> NDArray[np.bool_]:
        """Which steps count; the first never does, whose problem is lost."""
        far = np.abs(self.poses[:, 1]) > 0.1 if self.aside else np.ones(len(self.poses), bool)
        far[0] = False
        return far


class Watched:
    """A controller; keeps what it saw and commanded."""

    def __init__(self, law: Any) -> None:
        self.law, self.seen = law, list[tuple[float, ...]]()

    def step(self, x: float, y: float, yaw: float, speed: float, dt: float, /) -> float:
        """Steer."""
        steer = self.law(x, y, yaw, speed, dt)
        self.seen.append((x, y, yaw, speed, steer))
        return float(steer)


def courses(make: Any, condition: str, scenarios: Iterable[str] = FORWARD) -> list[Course]:
    """Let a controller drive scenarios under a condition, or from aside."""
    roads = {name: SCENARIOS[name] for name in scenarios}
    if aside := condition == ASIDE:
        road = SCENARIOS["beside"]
        roads = {f"{far} m": replace(road, start_offset=far) for far in OFFSETS}
    found: list[Course] = []
    for name, road in roads.items():
        made: list[Any] = []

        def keep(path: popsteer.Path, car: popsteer.Vehicle, made: Any = made) -> Watched:
            watched = Watched(steering(make(path, car)))
            made += (path, car, watched)
            return watched

        under = CONDITIONS["as told" if aside else condition]
        if trace := drive(road, under, suite_car(), keep, seed_of(name)).traceback:
            raise SystemExit(trace)
        path, car, watched = made
        seen = np.array(watched.seen)
        found.append(Course(path, car, seen[:, :4], seen[:, 4], aside))
    return found


def steering(law: Any) -> Any:
    """Give the call that answers with an angle."""
    return getattr(law, "steer", law.step)


def again(name: str, make: Any, course: Course) -> dict[str, Floats]:
    """Show a controller what it saw once more: the times of its steps [s]."""
    step, times = steering(make(course.path, course.car)), []
    for pose in course.poses.tolist():
        begun = time.perf_counter()
        step(*pose, STAGE)
        times.append(time.perf_counter() - begun)
    return {name: np.array(times)}


def problems(course: Course) -> tuple[dict[str, Floats], popsteer.Path]:
    """Give the MPC's problems along a course, and the path with tangents that it was told."""
    law = Recorded(course.path, course.car)
    for x, y, yaw, speed in course.poses.tolist():
        law.step(x, y, yaw, speed, STAGE)
    each = {name: np.array([of[name] for of in law.problems], float) for name in law.problems[0]}
    return each, law.told


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


def by_whole(solve: Any, course: Course, path: popsteer.Path) -> tuple[Floats, Floats]:
    """Let the whole MPC in C see what the one in Python did: its commands, and times [s].

    The path is prepared as curves: the direction of each segment as a cubic of the share of it.
    """
    car, count = course.car, len(course.poses)
    xy, arc = np.column_stack((path.x, path.y)), np.asarray(path.s)
    if path.closed:
        xy, arc = np.vstack((xy, xy[:1])), np.append(arc, path.length)
    segments = len(arc) - 1
    bends = cubics(path, car)
    beyond = _path_headings(path, SMOOTHING * car.wheelbase, segments - 1, arc[-1], np.arange(2.0))
    point = car.rear_axle if car.no_slip_point is None else car.no_slip_point
    q, r = weights(car.wheelbase, **asdict(Weights()))
    own = (car.wheelbase, car.turning_length(0.0), car.understeer, car.steer_lag, car.max_steer)
    limits = (car.max_steer_rate, car.max_lateral_acceleration)
    told = np.array((*own, *limits, point, STAGE, q[0, 0], q[1, 1], r[0, 0]), float)
    reach = 5.0 * SMOOTHING * car.wheelbase
    first = path.relocalise(*course.poses[0, :3].tolist())
    sums = np.tril(np.ones((STAGES, STAGES)))
    road = (segments, int(path.closed), xy, arc, bends, float(np.diff(beyond)[0]), reach)
    return call(solve, count, told, *road, sums, first, course.poses)


def cubics(path: popsteer.Path, car: popsteer.Vehicle) -> Floats:
    """Give each segment's direction [rad] as a cubic of the share of it: four coefficients."""
    arc = np.append(path.s, path.length) if path.closed else np.asarray(path.s)
    shares = np.linspace(0.0, 1.0, 4)
    # Short of its end, which belongs to the next.
    at = arc[:-1, None] + np.diff(arc)[:, None] * shares * (1.0 - 1e-12)
    headings = _path_headings(path, SMOOTHING * car.wheelbase, 0, 0.0, at.ravel())
    powers = np.vander(shares, increasing=True)
    return np.array(np.linalg.solve(powers, headings.reshape(-1, 4).T).T, float)


class Solvers:
    """The yardsticks in C, compiled; how far they are apart from the MPC in Python."""

    def __init__(self, folder: Path) -> None:
        self.daqp = build(folder, "daqp", "qp_daqp.c", *DAQP)
        self.whole = build(folder, "daqp", "mpc_daqp.c", *DAQP)
        self.tiny = build(folder, "tinympc", "qp_tinympc.cpp", *TINYMPC)
        self.moves: list[Floats] = []
        self.commands: list[Floats] = []

    def times(self, course: Course) -> dict[str, Floats]:
        """Time the MPC's problems along a course, and the whole MPC in C [s]."""
        of, path = problems(course)
        fresh = of["fresh"] > 0.0
        exact, by = by_daqp(self.daqp, of)
        moves, tiny = by_tinympc(self.tiny, of)
        commands, whole = by_whole(self.whole, course, path)
        self.moves.append(np.abs(moves - exact)[course.counts[1:]])
        self.commands.append(np.abs(commands - course.commands))
        solved = {OWN: of[OWN], CALLED: of[CALLED], KEPT: by, FRESH: by, TINY: tiny}
        solved |= dict.fromkeys((WHOLE, WHOLE_KEPT, WHOLE_FRESH), whole[1:])
        for name in (KEPT, TINY, WHOLE_KEPT):
            solved[name] = np.where(fresh, np.nan, solved[name])
        for name in (FRESH, WHOLE_FRESH):
            solved[name] = np.where(fresh, solved[name], np.nan)
        # The first problem sets the solver up.
        return {name: np.append((np.nan, np.nan), each[1:]) for name, each in solved.items()}


def least(times: Callable[[Course], dict[str, Floats]], driven: list[Course]) -> dict[str, Floats]:
    """Give the steps that count, each the least of several passes [s]: of the law, not the load."""
    found: dict[str, list[Floats]] = {}
    for course in driven:
        passes = [times(course) for _ in range(PASSES)]
        for name in passes[0]:
            each = np.min([of[name] for of in passes], axis=0)[course.counts]
            found.setdefault(name, []).append(each[np.isfinite(each)])
    return {name: np.concatenate(each) for name, each in found.items()}


def main() -> None:
    """Time them; write the page."""
    solvers = Solvers(Path(sys.argv[1] if len(sys.argv) > 1 else "out/solvers"))
    bare = partial(popsteer.PreviewPop, adapt=None, monitor=None)
    ours: dict[str, Any] = {OURS: popsteer.PreviewPop, BARE: bare}
    figures: dict[str, list[float]] = {}
    apart: list[float] = []
    for condition in UNDER:
        found = least(solvers.times, courses(Recorded, condition))
        for name, make in ours.items():
            found |= least(partial(again, name, make), courses(make, condition))
        for name, each in found.items():
            quantiles = 1e6 * np.quantile(each, (0.5, 0.999))
            figures.setdefault(name, []).extend(quantiles.tolist())
        apart.append(1e3 * float(np.quantile(np.concatenate(solvers.moves), 0.95)))
        solvers.moves.clear()
    off = max(float(each.max()) for each in solvers.commands)
    if off > AGREE:
        raise SystemExit(f"the MPC in C answers otherwise than the one in Python: by {off} rad")
    named = {
        TINY: f"{TINY}; 95 % of its first moves within {', '.join(f'{a:.2g}' for a in apart)}"
        " mrad of daqp's",
        WHOLE: f"{WHOLE}; its commands within {off:.0e} rad of Python's",
    }
    rows = [(named.get(name, name), *(f"{v:.2f}" for v in of)) for name, of in figures.items()]
    for name, (one, other) in RATIOS.items():
        pairs = zip(figures[one], figures[other], strict=True)
        rows.append((name, *(f"{a / b:.2f}" for a, b in pairs)))
    lines = [
        line("", *(f"{under}: {of}" for under in UNDER for of in ("p50 [µs]", "p99.9"))),
        "|---|" + 2 * len(UNDER) * "--:|",
        *(line(*row) for row in rows),
    ]
    print("\n".join(lines))
    write_blocks(ROOT / "benches" / "README.md", {"solvers": "\n".join(lines)})


if __name__ == "__main__":
    main()
