"""Where to stop, which gear, how fast: a car that parks by what its controller says."""

from __future__ import annotations

import math
import re
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
import pytest

import popsteer
from popsteer import sim
from popsteer.tracks import cusps
from studies.chain import Chain
from tests.helpers import ROOT

if TYPE_CHECKING:
    from collections.abc import Callable

DT = 0.05
CAR = popsteer.Vehicle(
    wheelbase=2.7, rear_axle=-1.35, dead_time=0.1, max_steer=0.6, max_steer_rate=0.6
)
AT_REAR = popsteer.Vehicle(wheelbase=2.7, max_steer=0.6, max_steer_rate=0.6)
PARAMS = popsteer.PreviewPopParams(min_speed=1.0, smoothing_length=0.5)


class Driven(Protocol):
    """A car as the ten lines of the page take it."""

    @property
    def pose(self) -> tuple[float, float, float]: ...
    @property
    def speed(self) -> float: ...
    def drive(self, steer: float, speed: float, dt: float) -> None: ...


class OnChain:
    """The independent bicycle, whose speed follows at 1.5 m/s² at most."""

    vehicle = CAR

    def __init__(self) -> None:
        self.chain = Chain(CAR, (1.35, 0.0, 0.0), 0.0, DT, substeps=10)

    @property
    def pose(self) -> tuple[float, float, float]:
        return self.chain.pose

    @property
    def speed(self) -> float:
        return self.chain.speed

    def drive(self, steer: float, speed: float, dt: float) -> None:
        gain = max(-1.5 * dt, min(speed - self.chain.speed, 1.5 * dt))
        self.chain.speed += gain
        self.chain.advance(steer)


def _pedals(speed: float, wanted: float) -> tuple[float, float, bool]:
    """Throttle and brake that bring a car from one speed to another, and its gear."""
    backwards = wanted < 0.0 or (wanted == 0.0 and speed < 0.0)
    push = (wanted - speed) * (-1.0 if backwards else 1.0)
    brake = 1.0 if wanted == 0.0 else max(0.0, min(-2.0 * push, 1.0))
    return max(0.0, min(push, 1.0)), brake, backwards


class OnPlant:
    """A plant of `popsteer.sim`, by its pedals."""

    vehicle = AT_REAR

    def __init__(self, path: popsteer.Path) -> None:
        plant = sim.KinematicBicycle(AT_REAR)
        settings = sim.Settings(stop_distance=0.0)
        self.run = sim.Simulation(path, plant, start=(0.0, 0.0, 0.0), settings=settings)

    @property
    def pose(self) -> tuple[float, float, float]:
        x, y, yaw, _ = self.run.state
        return x, y, yaw

    @property
    def speed(self) -> float:
        return self.run.state[3]

    def drive(self, steer: float, speed: float, _dt: float) -> None:
        self.run.step(steer, *_pedals(self.speed, speed))


class OnMujoco:
    """The car in MuJoCo, by its pedals."""

    def __init__(self) -> None:
        self.car = pytest.importorskip("popsteer.plants.mujoco_car").MujocoCar()
        self.vehicle = self.car.vehicle
        self.car.reset(0.0, 0.0, 0.0, 0.0)
        self.pose = (0.0, 0.0, 0.0)
        self.speed = 0.0

    def drive(self, steer: float, speed: float, dt: float) -> None:
        throttle, brake, backwards = _pedals(self.speed, speed)
        state = self.car.advance(steer, throttle, brake, dt / 25, 25, backwards)
        self.pose, self.speed = (state.x, state.y, state.yaw), state.speed


def _car(name: str, path: popsteer.Path) -> Any:
    return {"chain": OnChain, "bicycle": lambda: OnPlant(path), "mujoco": OnMujoco}[name]()


def _park() -> Callable[[Any, Driven], popsteer.Command]:
    """The ten lines that `docs/edges.md` shows."""
    page = (ROOT / "docs" / "edges.md").read_text(encoding="utf-8")
    (lines,) = re.findall(r"```python\n(def park\(.*?)```", page, re.DOTALL)
    assert len(lines.splitlines()) <= 12
    names: dict[str, Any] = {"math": math}
    exec(lines, names)
    park: Callable[[Any, Driven], popsteer.Command] = names["park"]
    return park


def _path(track: str, speeds: str) -> popsteer.Path:
    made = {"parallel": cusps.parallel_parking, "three-point": cusps.three_point_turn}[track]()
    path = popsteer.Path(made.xy, speed=made.speed)
    if speeds == "profile":
        return path
    # As a planner gives them: 1.5 m/s, and standing at the start, at each cusp and at the end.
    assert path.reverse is not None
    reverse = np.asarray(path.reverse)
    speed = np.where(reverse, -1.5, 1.5)
    speed[[0, *(np.flatnonzero(np.diff(reverse)) + 1), -1]] = 0.0
    return popsteer.Path(made.xy, speed=speed, reverse=reverse)


@pytest.mark.parametrize("name", ["chain", "bicycle", "mujoco"])
@pytest.mark.parametrize("track", ["parallel", "three-point"])
@pytest.mark.parametrize("speeds", ["profile", "standing"])
def test_car_with_two_cusps_parks_within_a_decimetre(name: str, track: str, speeds: str) -> None:
    path = _path(track, speeds)
    car = _car(name, path)
    steps = 0
    drive = car.drive

    def counted(*args: float) -> None:
        nonlocal steps
        steps += 1
        assert steps * DT < 120.0, "it stands still before the end"
        drive(*args)

    car.drive = counted
    command = _park()(popsteer.PreviewPop(path, car.vehicle, PARAMS), car)
    x, y, yaw = car.pose
    x += car.vehicle.rear_axle * math.cos(yaw)
    y += car.vehicle.rear_axle * math.sin(yaw)
    along = (path.x[-1] - path.x[-2], path.y[-1] - path.y[-2])
    off = math.remainder(yaw - math.atan2(along[1], along[0]), math.tau)
    assert math.hypot(x - path.x[-1], y - path.y[-1]) < 0.1
    assert abs(math.degrees(off)) < 2.0
    assert abs(command.distance_to_stop) < 0.1


@pytest.mark.parametrize("name", ["Pop", "PreviewPop", "Pid", "PurePursuit", "Stanley"])
def test_distance_to_stop_is_that_of_the_rear_axle_in_its_section(name: str) -> None:
    # 20 m forward, 10 m back, 20 m forward.
    x = [*np.arange(0.0, 20.0), *np.arange(20.0, 10.0, -1.0), *np.arange(10.0, 31.0)]
    reverse = [20 <= k < 30 for k in range(len(x))]
    speed = [-1.0 if back else 1.0 for back in reverse]
    path = popsteer.Path([(each, 0.0) for each in x], speed=speed)
    controller = getattr(popsteer, name)(path, CAR.replace(dead_time=0.0))
    cases = [
        *((rear, 1.0, 20.0 - rear) for rear in np.arange(0.0, 19.8, 0.4)),
        *((rear, -1.0, rear - 10.0) for rear in np.arange(19.88, 10.2, -0.4)),
        *((rear, 1.0, 30.0 - rear) for rear in np.arange(10.12, 30.5, 0.4)),
    ]
    for rear, pace, distance in cases:
        # Where it turns round the rear axle is within a twentieth of the wheelbase.
        command = controller.step(rear + 1.35, 0.02, 0.0, pace, 0.05)
        assert command.distance_to_stop == pytest.approx(distance, abs=1e-9), rear
        assert command.reference_speed == pytest.approx(pace)
        assert command.reverse == (pace < 0.0)


def test_closed_path_has_no_stop_and_a_path_without_speeds_no_reference() -> None:
    ring = [(20.0 * math.cos(0.1 * k), 20.0 * math.sin(0.1 * k)) for k in range(62)]
    command = popsteer.Stanley(popsteer.Path(ring, closed=True)).step(20.0, 0.0, 1.6, 5.0, DT)
    assert command.distance_to_stop == math.inf
    assert command.reference_speed is None


def test_batch_says_the_same_in_columns() -> None:
    line = [(float(k), 0.0) for k in range(50)]
    paths = [popsteer.Path(line, speed=[0.1 * k for k in range(50)]), popsteer.Path(line)]
    commands = popsteer.Batch([popsteer.Pop(path) for path in paths]).step(
        np.array([5.0, 7.5]), np.zeros(2), np.zeros(2), np.full(2, 3.0), DT
    )
    np.testing.assert_allclose(commands.distance_to_stop, [44.0, 41.5])
    assert commands.reference_speed[0] == pytest.approx(0.5)
    assert math.isnan(commands.reference_speed[1])


def test_held_input_holds_both_numbers() -> None:
    path = popsteer.Path([(float(k), 0.0) for k in range(50)], speed=[2.0] * 50)
    controller = popsteer.Stanley(path)
    first = controller.step_or_hold(math.nan, 0.0, 0.0, 1.0, DT)
    assert (first.reference_speed, first.distance_to_stop) == (None, 0.0)
    good = controller.step(10.0, 0.0, 0.0, 2.0, DT)
    held = controller.step_or_hold(math.nan, 0.0, 0.0, 2.0, DT)
    assert (held.reference_speed, held.distance_to_stop) == (2.0, good.distance_to_stop)


@pytest.mark.parametrize("track", ["parallel", "three-point"])
def test_closed_loop_passes_cusps_at_which_the_path_stands_still(track: str) -> None:
    path = _path(track, "standing")
    controller = popsteer.PreviewPop(path, AT_REAR, PARAMS)
    result = sim.run(
        controller,
        sim.KinematicBicycle(AT_REAR),
        longitudinal=popsteer.SpeedPid(popsteer.SpeedPidParams(kp=1.0, ki=0.5)),
        start=(0.0, 0.0, 0.0),
    )
    assert result.ending == "finished"
    assert np.abs(result.records["rear_cross_track_error"]).max() < 1.0


def test_closed_loop_brakes_for_cusps_that_the_speeds_do_not_know() -> None:
    made = cusps.parallel_parking(final=10.0)
    path = popsteer.Path(made.xy, speed=np.where(made.speed < 0.0, -3.0, 3.0))
    controller = popsteer.PreviewPop(path, AT_REAR, PARAMS)
    result = sim.run(
        controller,
        sim.KinematicBicycle(AT_REAR),
        longitudinal=popsteer.SpeedPid(popsteer.SpeedPidParams(kp=1.0, ki=0.1)),
        start=(0.0, 0.0, 0.0),
    )
    assert result.ending == "finished"
    # The first cusp is 10 m along x; the brakes of 9 m/s² are strong.
    backwards = int(np.argmax(result.records["speed"] < 0.0))
    assert 9.8 < result.records["x"][:backwards].max() < 10.6
