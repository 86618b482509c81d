"""Signs and units between CARLA and popsteer, with the real client library."""

from __future__ import annotations

import math
import subprocess
import sys
from typing import TYPE_CHECKING

import numpy as np
import pytest

import popsteer
from popsteer.adapters import carla as adapter
from tests.helpers import ROOT, looped

if TYPE_CHECKING:
    from collections.abc import Sequence

pytest.importorskip("carla", reason='the extra "carla" is not installed')

import carla
from hypothesis import given
from hypothesis import strategies as st

from popsteer.adapters.carla.conversions import axles_of, curve_of
from popsteer.adapters.carla.route import Route, option_between

FRONT = ((1.5, -0.8), (1.5, 0.8))
REAR = ((-1.4, -0.8), (-1.4, 0.8))


def wheels_at(
    transform: carla.Transform,
    unit: float = 100.0,
    places: Sequence[tuple[float, float]] = (*FRONT, *REAR),
) -> list[carla.WheelPhysicsControl]:
    found = []
    for ahead, right in places:
        place = transform.transform(carla.Location(ahead, right, 0.0))
        wheel = carla.WheelPhysicsControl(max_steer_angle=60.0 if ahead > 0 else 0.0)
        wheel.position = carla.Vector3D(unit * place.x, unit * place.y, 0.0)
        found.append(wheel)
    return found


class Parked:
    """An actor that says where it is and what its wheels are."""

    def __init__(self, transform: carla.Transform, wheels: list[carla.WheelPhysicsControl]) -> None:
        self.transform = transform
        self.physics = carla.VehiclePhysicsControl(
            wheels=wheels, steering_curve=[carla.Vector2D(0.0, 1.0), carla.Vector2D(50.0, 0.8)]
        )

        self.bounding_box = carla.BoundingBox(carla.Location(), carla.Vector3D(2.3, 0.9, 0.8))

    def get_transform(self) -> carla.Transform:
        return self.transform

    def get_physics_control(self) -> carla.VehiclePhysicsControl:
        return self.physics


HERE = carla.Transform(carla.Location(120.0, -45.0, 1.0), carla.Rotation(yaw=130.0))


def test_pose_of_the_four_directions() -> None:
    # CARLA's y points right: at yaw 90° a car looks to its former right, which is −y here.
    for degrees, ahead in ((0, (1, 0)), (90, (0, -1)), (180, (-1, 0)), (-90, (0, 1))):
        transform = carla.Transform(carla.Location(), carla.Rotation(yaw=degrees))
        _, _, yaw = adapter.pose_of(transform)
        assert (math.cos(yaw), math.sin(yaw)) == pytest.approx(ahead, abs=1e-6)
        forward = transform.get_forward_vector()
        assert (forward.x, -forward.y) == pytest.approx(ahead, abs=1e-6)


@given(x=st.floats(-1e3, 1e3), y=st.floats(-1e3, 1e3), yaw=st.floats(-3.0, 3.0))
def test_pose_comes_back_from_its_transform(x: float, y: float, yaw: float) -> None:
    back = adapter.pose_of(adapter.transform_of(x, y, yaw))
    assert back == pytest.approx((x, y, yaw), abs=1e-4)


@looped("yaw", [0.0, 60.0, -135.0])
def test_speed_is_signed_by_where_the_car_looks(yaw: float) -> None:
    transform = carla.Transform(carla.Location(), carla.Rotation(yaw=yaw))
    ahead = transform.get_forward_vector()
    right = transform.get_right_vector()
    for speed in (5.0, -2.0):
        velocity = carla.Vector3D(
            speed * ahead.x + 0.7 * right.x, speed * ahead.y + 0.7 * right.y, 0.0
        )
        assert adapter.speed_of(velocity, transform) == pytest.approx(speed, abs=1e-5)


@given(angle=st.floats(-1.0, 1.0), speed=st.floats(-60.0, 60.0))
def test_angle_comes_back_from_its_share_within_the_lock(angle: float, speed: float) -> None:
    steering = adapter.Steering(1.2, ((0.0, 1.0), (20.0, 0.9), (120.0, 0.7)))
    share = steering.share(angle, speed)
    assert -1.0 <= share <= 1.0
    full = steering.at_full(speed)
    assert steering.angle(share, speed) == pytest.approx(max(-full, min(angle, full)))
    assert share * angle <= 0.0  # CARLA's steer is positive to the right


def test_lock_at_speed_follows_the_steering_curve() -> None:
    # Linear between the points, constant beyond them, as numpy interpolates.
    for curve in (
        ((10.0, 0.9), (20.0, 0.5), (80.0, 0.6)),
        ((0.0, 0.7), (50.0, 1.0)),
        ((30.0, 0.8),),
    ):
        steering = adapter.Steering(1.2, curve)
        for kmh in np.linspace(-100.0, 100.0, 81).tolist():
            speeds, factors = np.array(curve).T
            factor = np.interp(abs(kmh), speeds, factors)
            assert steering.at_full(kmh / 3.6) == pytest.approx(1.2 * factor), (curve, kmh)


def test_curve_that_is_none_counts_as_none() -> None:
    for points in ([(10, 0.5), (10, 0.5)], [(20, 1), (10, 0.5)], [(0, 0)], [(0, 2)], []):
        assert curve_of([carla.Vector2D(*map(float, point)) for point in points]) == ()


def test_controls_are_bounded_and_turn_the_other_way() -> None:
    steering = adapter.Steering(lock=1.0)
    control = adapter.vehicle_control(0.5, 1.5, -1.0, steering=steering, reverse=True)
    assert (control.steer, control.throttle, control.brake) == (-0.5, 1.0, 0.0)
    assert control.reverse
    assert not control.hand_brake
    assert adapter.vehicle_control(-9.0, 0.0, 0.0, steering=steering).steer == 1.0
    ackermann = adapter.ackermann_control(0.25, 7.0, steer_rate=0.5, acceleration=2.0)
    assert (ackermann.steer, ackermann.speed) == (-0.25, 7.0)
    assert (ackermann.steer_speed, ackermann.acceleration) == (0.5, 2.0)


@looped("lock", [0.0, 1.6, math.nan])
def test_lock_out_of_its_range_is_refused_by_name(lock: float) -> None:
    with pytest.raises(popsteer.ConfigError, match="lock must be in"):
        adapter.Steering(lock=lock)


@looped("unit", [100.0, 1.0])
def test_vehicle_of_an_actor_has_its_axles_and_its_lock(unit: float) -> None:
    car = adapter.vehicle_of(Parked(HERE, wheels_at(HERE, unit)))
    assert car.wheelbase == pytest.approx(2.9, abs=1e-4)
    assert car.rear_axle == pytest.approx(-1.4, abs=1e-4)
    assert car.max_steer == pytest.approx(math.radians(60.0))
    assert car.width == pytest.approx(1.8)
    assert car.steer_lag == popsteer.Vehicle().steer_lag
    steering = adapter.steering_of(Parked(HERE, wheels_at(HERE, unit)))
    assert steering.lock == car.max_steer
    assert np.array(steering.curve) == pytest.approx(np.array([(0.0, 1.0), (50.0, 0.8)]))


def test_rear_axle_of_a_truck_is_in_the_middle_of_its_axles() -> None:
    places = (*FRONT, (-2.0, -1.0), (-2.0, 1.0), (-3.0, -1.0), (-3.0, 1.0))
    wheelbase, rear_axle = axles_of(wheels_at(HERE, 100.0, places), HERE)
    assert wheelbase == pytest.approx(4.0, abs=1e-4)
    assert rear_axle == pytest.approx(-2.5, abs=1e-4)


def test_three_wheels_are_a_car_and_two_are_none() -> None:
    places = (*FRONT, (-2.0, 0.0))
    assert axles_of(wheels_at(HERE, 100.0, places), HERE) == pytest.approx((3.5, -2.0), abs=1e-4)
    with pytest.raises(popsteer.PopsteerError, match="has 2 wheels"):
        axles_of(wheels_at(HERE, 100.0, FRONT), HERE)


def test_fields_that_are_given_take_the_place_of_the_actors() -> None:
    nowhere = [carla.WheelPhysicsControl() for _ in range(4)]
    car = adapter.vehicle_of(Parked(HERE, nowhere), wheelbase=3.0, rear_axle=-1.5, dead_time=0.1)
    assert (car.wheelbase, car.rear_axle, car.dead_time) == (3.0, -1.5, 0.1)
    car = adapter.vehicle_of(Parked(HERE, wheels_at(HERE)), wheelbase=3.0, max_steer=0.5, width=2.1)
    assert (car.wheelbase, car.max_steer, car.width) == (3.0, 0.5, 2.1)
    assert car.rear_axle == pytest.approx(-1.4, abs=1e-4)


def test_actor_that_says_nothing_of_its_wheels_is_refused() -> None:
    nowhere = [carla.WheelPhysicsControl() for _ in range(4)]
    with pytest.raises(popsteer.PopsteerError, match="does not say where the wheels are"):
        adapter.vehicle_of(Parked(HERE, nowhere))
    with pytest.raises(popsteer.PopsteerError, match="has 0 wheels"):
        adapter.vehicle_of(Parked(HERE, []))
    # Before its first tick an actor says that it is at the origin.
    with pytest.raises(popsteer.PopsteerError, match="let the world tick"):
        adapter.vehicle_of(Parked(carla.Transform(), wheels_at(HERE)))


def test_branches_are_named_by_where_they_turn() -> None:
    class Looking:
        def __init__(self, yaw: float) -> None:
            self.transform = carla.Transform(carla.Location(), carla.Rotation(yaw=yaw))

    for before, after, wanted in (
        (0.0, 20.0, adapter.RoadOption.STRAIGHT),
        (0.0, 90.0, adapter.RoadOption.RIGHT),
        (0.0, -60.0, adapter.RoadOption.LEFT),
        (170.0, -100.0, adapter.RoadOption.RIGHT),
    ):
        assert option_between(Looking(before), Looking(after)) == wanted


class Forking:
    """A lane that goes straight on for 10 m, and forks to the left and the right there."""

    def __init__(self, x: float, y: float, yaw: float) -> None:
        self.transform = carla.Transform(carla.Location(x, y, 0.0), carla.Rotation(yaw=yaw))

    def next(self, distance: float) -> list[Forking]:
        x, y = self.transform.location.x, self.transform.location.y
        yaw = self.transform.rotation.yaw
        if yaw == 0.0 and x < 10.0:
            return [Forking(x + distance, y, 0.0)]
        if yaw == 0.0:
            return [Forking(x, y - distance, -90.0), Forking(x, y + distance, 90.0)]
        return [Forking(x, y + math.copysign(distance, yaw), yaw)] if abs(y) < 10.0 else []


def test_lane_that_forks_is_followed_along_either_branch() -> None:
    branches = set()
    for _ in range(50):
        found = Route(Forking(0.0, 0.0, 0.0))
        found.grow(100, 2.0)
        options = [option for _, option in found.ahead]
        (turn,) = [option for option in options if option != adapter.RoadOption.LANEFOLLOW]
        path = found.path(8.0)
        assert path is not None
        assert path.speed is not None
        assert set(path.speed) == {8.0}
        assert options.index(turn) == 6
        # CARLA's y points right, popsteer's left.
        assert (path.y[-1] > 0.0) == (turn == adapter.RoadOption.LEFT)
        branches.add(turn)
    assert branches == {adapter.RoadOption.LEFT, adapter.RoadOption.RIGHT}


class Merging(Forking):
    """Two lanes that meet in one, which begins where they do; each has what led to it."""

    def previous(self, distance: float) -> list[Merging]:
        x, y = self.transform.location.x, self.transform.location.y
        if x > 0.0:
            return [Merging(x - distance, 0.0, 0.0)]
        return [Merging(x - distance, y + side, 0.0) for side in (self.sides if x == 0.0 else (0,))]

    sides: tuple[float, ...] = (-3.0, 3.0)


@pytest.mark.parametrize("sides", [(-3.0, 3.0), (3.0, -3.0)])
def test_plan_behind_a_merge_is_led_in_along_the_lane_of_the_vehicle(
    sides: tuple[float, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Merging, "sides", sides)
    for lane in (-3.0, 3.0):
        found = Route(Merging(4.0, 0.0, 0.0))
        plan = [(Merging(2.0 * k, 0.0, 0.0), adapter.RoadOption.LANEFOLLOW) for k in range(2, 20)]
        found.replace(plan, carla.Location(-6.0, lane, 0.0))
        path = found.path(8.0)
        assert path is not None
        assert path.x[0] <= -6.0
        # CARLA's y points right, popsteer's left.
        assert {y for x, y in zip(path.x, path.y, strict=True) if x < 0.0} == {-lane}


def test_example_without_a_simulator_ends_with_one_line_and_status_2() -> None:
    ended = subprocess.run(
        [sys.executable, ROOT / "examples" / "carla_drive.py", "--port", "1", "--timeout", "0.5"],
        check=False,
        capture_output=True,
        text=True,
    )
    assert ended.returncode == 2
    assert ended.stdout == ""
    (line,) = ended.stderr.splitlines()
    assert line.startswith("carla_drive: time-out of 500ms while waiting for the simulator")


def test_waypoints_that_a_path_does_not_have_lie_beside_those_that_it_has() -> None:
    """As an agent's second plan has them: a step back where it was, and a stretch aside."""
    places = [0.0, 2.0, 4.0, 6.0, 5.0, 4.5, 6.5, 8.0, 10.0, 12.0, 14.0, 16.0, 18.0, 20.0]
    waypoints = [Forking(x, 0.0, 0.0) for x in places]
    found = Route(waypoints[0])
    found.add((waypoint, adapter.RoadOption.LANEFOLLOW) for waypoint in waypoints[1:])
    path = found.path(8.0)
    assert path is not None
    assert len(path) < len(places)  # it is mended
    found.pass_until(9.0, 0.5, 0.5)
    assert found.ahead[0][0].transform.location.x == 10.0
    found.pass_until(20.0, 0.5, 0.5)
    assert not found.ahead
