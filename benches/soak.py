"""Steps controllers 100,000,000 times and watches the memory of the process.

    python benches/soak.py                     # half a minute
    python benches/soak.py --steps 1000000     # a quick look
    python benches/soak.py --json FILE         # write the samples to FILE besides

All controllers take turns on the racetrack. Four steps in five are calls of their own, `step` and
`steer` by turns; the fifth is made by `Batch`, a thousand vehicles a call. Each round also refuses
bad inputs, resets, relocalises, saves, pickles and restores the state, and makes paths and
controllers that it throws away.

Memory is what the process has resident. It is held against that after the first tenth of the
steps, when all that is kept has been made: more than `BOUND` above it, or an answer that is not
within the limits, and the exit code is 1.
"""

from __future__ import annotations

import argparse
import json
import os
import pickle
import subprocess
import sys
from dataclasses import asdict, dataclass
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Any

import numpy as np

import popsteer
from popsteer import InputError, tracks
from popsteer.files import write_text_atomic

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from numpy.typing import NDArray

STEPS = 100_000_000
BOUND = 1024 * 1024
"""How much may be resident more at the end than after the first tenth [bytes]."""
LAWS = ("Pop", "PurePursuit", "Stanley", "Pid")
VEHICLES = 1000
CALLS = 16_000
BATCHES = 4
ROUND = CALLS + BATCHES * VEHICLES
"""Steps of one controller in one round: calls of their own, and those of the batches."""
SAMPLES = 40
DT = 0.05


class Fault(Exception):  # noqa: N818 - what is found, not what went wrong here
    """An answer that should not be."""


@dataclass(frozen=True)
class Sample:
    """What was resident after so many steps."""

    steps: int
    seconds: float
    resident: int


@dataclass
class Soaked:
    """What a run came to."""

    called: int
    batched: int
    samples: list[Sample]

    @property
    def steps(self) -> int:
        """Steps of both kinds."""
        return self.called + self.batched


def resident() -> int:
    """Memory of this process [bytes]."""
    statm = Path("/proc/self/statm")
    if statm.exists():
        return int(statm.read_text(encoding="ascii").split()[1]) * os.sysconf("SC_PAGESIZE")
    command = ["ps", "-o", "rss=", "-p", str(os.getpid())]
    return 1024 * int(subprocess.run(command, capture_output=True, check=True).stdout)


def poses(track: tracks.Track) -> NDArray[np.float64]:
    """Poses and speeds all along the track, beside it by up to 2 m, shape (N, 4)."""
    xy = np.asarray(track.xy)
    along = np.diff(xy, axis=0)
    rng = np.random.default_rng(1)
    beside = rng.uniform(-2.0, 2.0, (len(along), 2))
    yaw = np.arctan2(along[:, 1], along[:, 0]) + rng.uniform(-0.3, 0.3, len(along))
    return np.column_stack((xy[:-1] + beside, yaw, rng.uniform(0.0, 25.0, len(along))))


class Soak:
    """One controller, its batch, and where its vehicles are."""

    def __init__(self, law: str, path: popsteer.Path, vehicles: NDArray[np.float64]) -> None:
        self._controller: Any = getattr(popsteer, law)(path)
        self._batch = popsteer.Batch(self._controller, VEHICLES)
        self._vehicles = vehicles
        self._list = vehicles.tolist()
        self._max_steer = self._controller.vehicle.max_steer

    def go_round(self, number: int) -> None:
        """Make the steps of one round, `ROUND` of them, and all that is not a step."""
        self._call(number * CALLS)
        for batch in range(number * BATCHES, (number + 1) * BATCHES):
            places = (np.arange(VEHICLES) * 7 + batch) % len(self._vehicles)
            x, y, yaw, speed = np.ascontiguousarray(self._vehicles[places].T)
            if batch % 2:
                steer = self._batch.step(x, y, yaw, speed, DT).steer
            else:
                steer = self._batch.steer(x, y, yaw, speed, DT)
            if not np.all(np.abs(steer) <= self._max_steer):
                raise Fault(f"a batch of {self._controller!r} steers beyond {self._max_steer}")
        self._disturb()

    def _call(self, first: int) -> None:
        step, steer, limit = self._controller.step, self._controller.steer, self._max_steer
        states, count = self._list, len(self._list)
        for k in range(first, first + CALLS, 2):
            x, y, yaw, speed = states[k % count]
            angle = steer(x, y, yaw, speed, DT)
            x, y, yaw, speed = states[(k + 1) % count]
            command = step(x, y, yaw, speed, DT)
            if not (abs(angle) <= limit and abs(command.steer) <= limit):
                raise Fault(f"{self._controller!r} steers beyond {limit}")

    def _disturb(self) -> None:
        """Do once what a controller is asked for beside steps."""
        law = self._controller
        saved = pickle.loads(pickle.dumps(law.state))
        for bad in ((float("nan"), 0.0, 0.0, 1.0, DT), (0.0, 0.0, 0.0, 1.0, float("nan"))):
            try:
                law.step(*bad)
            except InputError:
                continue
            raise Fault(f"{law!r} took {bad}")
        if law.state != saved:
            raise Fault(f"{law!r} has another state after bad input")
        law.relocalise(*self._list[0][:3])
        law.reset()
        path = popsteer.Path(self._vehicles[:100, :2], mend=False)
        type(law)(path, law.vehicle, law.params).step(*self._list[0], DT)
        law.state = saved


def soak(steps: int) -> Iterator[Soaked]:
    """Step at least so many times; yields what it has come to whenever memory was sampled."""
    track = tracks.get("racetrack")
    path = popsteer.Path(track.xy, speed=track.speed, closed=track.closed)
    vehicles = poses(track)
    laws = [Soak(law, path, vehicles) for law in LAWS]
    rounds = -(-steps // (ROUND * len(laws)))
    every = max(1, rounds // SAMPLES)
    run = Soaked(0, 0, [])
    begin = perf_counter()
    for number in range(rounds):
        for law in laws:
            law.go_round(number)
        run.called += CALLS * len(laws)
        run.batched += (ROUND - CALLS) * len(laws)
        if (number + 1) % every == 0 or number + 1 == rounds:
            run.samples.append(Sample(run.steps, perf_counter() - begin, resident()))
            yield run


def growth(samples: Sequence[Sample]) -> int:
    """How much more was resident at most than after the first tenth of the steps [bytes]."""
    settled = next(each for each in samples if each.steps >= samples[-1].steps / 10)
    later = [each.resident for each in samples if each.steps >= settled.steps]
    return max(later) - settled.resident


def report(run: Soaked) -> str:
    """Lay out what a run came to."""
    rows = run.samples[:: max(1, len(run.samples) // 10)]
    if rows[-1] is not run.samples[-1]:
        rows.append(run.samples[-1])
    lines = ["| steps | seconds | resident [MiB] |", "| --: | --: | --: |"]
    lines += [
        f"| {each.steps:,} | {each.seconds:.0f} | {each.resident / 2**20:.2f} |" for each in rows
    ]
    counted = f"{run.called:,} by calls of their own, {run.batched:,} by batches"
    grown = f"{growth(run.samples) / 1024:,.0f} KiB after the first tenth"
    lines += ["", f"{run.steps:,} steps: {counted}."]
    lines += [f"Resident memory grew by {grown}; {BOUND // 1024:,} KiB are allowed."]
    return "\n".join(lines)


def main() -> int:
    """Read the command line, step, say what came of it."""
    parser = argparse.ArgumentParser(description=str(__doc__).partition("\n")[0])
    parser.add_argument("--steps", type=int, default=STEPS, help=f"at least (default: {STEPS:,})")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the samples there")
    asked = parser.parse_args()
    if asked.steps < 1:
        parser.error(f"--steps must be at least 1, got {asked.steps}")
    run, stopped = None, False
    first, end = ("\r", "") if sys.stderr.isatty() else ("", "\n")
    try:
        for run in soak(asked.steps):
            last = run.samples[-1]
            done = f"{last.steps / 1e6:,.1f} of {asked.steps / 1e6:,.1f} million steps"
            said = f"{first}{done}, {last.resident / 2**20:.1f} MiB"
            print(said, end=end, file=sys.stderr, flush=True)
    except KeyboardInterrupt:
        stopped = True
    except Fault as fault:
        print(f"\n{fault}", file=sys.stderr)
        return 1
    print(file=sys.stderr)
    if run is None:
        return 130
    print(report(run))
    if asked.json:
        summary = asdict(run) | {"growth": growth(run.samples), "bound": BOUND, "stopped": stopped}
        write_text_atomic(asked.json, json.dumps(summary, indent=2) + "\n")
    if growth(run.samples) > BOUND:
        print("memory grows", file=sys.stderr)
        return 1
    return 130 if stopped else 0


if __name__ == "__main__":
    sys.exit(main())
