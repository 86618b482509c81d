from __future__ import annotations

import math
import random
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import pytest

import popsteer
from benches.latency import measure as latency
from benches.latency import states, yardsticks
from benches.latency.calls import (
    DAQP_SOLVE,
    DAQP_STEP,
    DAQP_UPDATE,
    MPC_SOLVE,
    MPC_STEP,
    MPC_UPDATE,
    NUMBA_STEP,
)
from benches.latency.timing import Drive
from popsteer import reference
from tests.helpers import authors_data, looped

if TYPE_CHECKING:
    from benches.latency.timing import Driver


DT = states.DT


@pytest.fixture(scope="module")
def drive() -> Drive:
    """Some seconds of driving through the first bend."""
    whole = states.embedded()
    return replace(whole, states=whole.states[300:450])


@pytest.fixture(scope="module")
def found(drive: Drive) -> yardsticks.Yardsticks:
    """The yardsticks for that drive; numba compiles its step once, which takes seconds."""
    return yardsticks.at_hand(drive)


def numba_driver(drive: Drive) -> Driver:
    pytest.importorskip("numba")
    return yardsticks.at_hand(drive).makers[NUMBA_STEP]()


@pytest.fixture(scope="module")
def compiled(found: yardsticks.Yardsticks) -> Driver:
    pytest.importorskip("numba")
    return found.makers[NUMBA_STEP]()


def reference_angles(drive: Drive) -> list[float]:
    xy = zip(drive.path.x.tolist(), drive.path.y.tolist(), strict=True)
    path = reference.Path(xy, closed=drive.path.closed)
    pop = reference.Pop(reference.Vehicle(**drive.vehicle.as_dict()))
    tracker = reference.Tracker(pop, path)
    return [tracker.steer(*state, DT) for state in drive.states]


def test_numba_step_gives_the_angles_of_the_reference(drive: Drive, compiled: Driver) -> None:
    driver = compiled
    driver.reset()
    expected = reference_angles(drive)
    assert [driver.call(*state, DT) for state in drive.states] == expected
    driver.reset()
    assert driver.call(*drive.states[0], DT) == expected[0]
    assert len(set(expected)) > 10


def test_numba_step_gives_the_angles_of_the_core_over_the_authors_run() -> None:
    drive = states.recorded(authors_data())
    driver = numba_driver(drive)
    pop = popsteer.Pop(drive.path, drive.vehicle)
    expected = [pop.steer(*state, DT) for state in drive.states]
    assert [driver.call(*state, DT) for state in drive.states] == expected


@pytest.mark.parametrize("closed", [False, True])
def test_numba_step_gives_the_angles_of_the_reference_anywhere(closed: bool) -> None:
    # A square with bends that a grid and a lookahead circle meet in every way; states that jump.
    corners = [(0.0, 0.0), (9.0, 0.0), (11.0, 2.0), (11.0, 14.0), (4.0, 15.0), (-1.0, 12.0)]
    path = popsteer.Path(corners, closed=closed)
    dice = random.Random(5)
    jumps = [
        (dice.uniform(-9, 20), dice.uniform(-9, 24), dice.uniform(-9, 9), dice.uniform(-2, 30))
        for _ in range(300)
    ]
    car = popsteer.Vehicle(rear_axle=-1.94, max_lateral_acceleration=None)
    drive = Drive("jumps", path, jumps, car)
    driver = numba_driver(drive)
    assert [driver.call(*state, DT) for state in jumps] == reference_angles(drive)


@looped(
    "arguments",
    [(math.nan, 0, 0, 1, DT), (0, 0, math.inf, 1, DT), (0, 0, 0, 2e4, DT), (0, 0, 0, 1, 0)],
)
def test_numba_step_bad_input_is_refused(
    drive: Drive, compiled: Driver, arguments: tuple[float, ...]
) -> None:
    driver = compiled
    driver.reset()
    call: Any = driver.call
    with pytest.raises(ValueError, match="out of its bounds"):
        call(*map(float, arguments))
    assert driver.call(*drive.states[0], DT) == reference_angles(drive)[0]


def test_numba_step_of_a_path_driven_backwards_is_refused(drive: Drive) -> None:
    corners = [(0.0, 0.0), (9.0, 0.0), (0.0, 1.0)]
    path = popsteer.Path(corners, reverse=[False, True, False])
    with pytest.raises(ValueError, match="drives forward only"):
        numba_driver(replace(drive, path=path))


def test_numba_step_of_a_vehicle_with_a_dead_time_is_refused(drive: Drive) -> None:
    late = replace(drive, vehicle=drive.vehicle.replace(dead_time=0.1))
    with pytest.raises(ValueError, match="to the wheels as it is"):
        numba_driver(late)


def test_step_of_the_one_on_daqp_is_its_update_and_its_solve(
    drive: Drive, found: yardsticks.Yardsticks
) -> None:
    pytest.importorskip("daqp")
    whole, parted = found.makers[DAQP_STEP](), found.makers[DAQP_STEP]()
    assert parted.stages is not None
    assert list(parted.stages) == [DAQP_UPDATE, DAQP_SOLVE]
    update, solve = parted.stages.values()
    for state in drive.states[:40]:
        update(*state, DT)
        assert solve() == whole.call(*state, DT)


def test_mpc_step_is_its_update_and_its_solve(drive: Drive, found: yardsticks.Yardsticks) -> None:
    pytest.importorskip("osqp")
    whole, parted = found.makers[MPC_STEP](), found.makers[MPC_STEP]()
    assert parted.stages is not None
    assert list(parted.stages) == [MPC_UPDATE, MPC_SOLVE]
    update, solve = parted.stages.values()
    angles = []
    for state in drive.states:
        update(*state, DT)
        angles.append(solve())
    assert angles == [whole.call(*state, DT) for state in drive.states]
    whole.reset()
    # The solver's step size has adapted meanwhile; the answer is the same to its tolerance.
    assert whole.call(*drive.states[0], DT) == pytest.approx(angles[0], abs=1e-3)


def test_at_hand_without_the_extra_says_how_to_get_it(
    drive: Drive, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(yardsticks, "find_spec", lambda _name: None)
    found = yardsticks.at_hand(drive)
    assert not found.makers
    assert found.absent == dict.fromkeys(
        yardsticks.ROWS, "not installed: pip install numba daqp osqp scipy"
    )


def test_measure_with_yardsticks_fills_their_rows(
    drive: Drive, found: yardsticks.Yardsticks
) -> None:
    pytest.importorskip("numba")
    pytest.importorskip("osqp")
    pytest.importorskip("daqp")
    if popsteer.build_profile != "release":
        pytest.skip("needs a release build")
    report = latency.measure(drive, calls=320, reference_calls=1, outside=found)
    assert not report.absent
    assert all(report.results[name] is not None for name in yardsticks.ROWS)
    assert report.row(MPC_SOLVE).net_p50 is None
    for ratios in (report.ratios, report.net_ratios):
        assert all(ratio is not None and ratio > 0.0 for ratio in ratios.values())
