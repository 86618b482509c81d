"""A place on the whole path, and turning round at a cusp."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import pytest

import popsteer
from popsteer import InputError, Status
from popsteer.reference import Path
from popsteer.reference.path.follow import Follow
from popsteer.reference.vehicle.state import VehicleState
from tests.helpers import looped
from tests.parity.laws import LATERAL, Law
from tests.parity.test_path import BAD_POSES, figure_of_eight

if TYPE_CHECKING:
    from collections.abc import Sequence

CROSSING = popsteer.Path(figure_of_eight(), closed=True)


@pytest.mark.parametrize("law", LATERAL, ids=lambda law: law.name)
def test_law_relocalised_on_a_crossing_goes_by_the_heading(law: Law) -> None:
    controller = getattr(popsteer, law.name)(CROSSING)
    for warm in (False, True):
        if warm:
            for _ in range(2):
                controller.step(20.0, 8.0, 0.2, 5.0, 0.05)
        before = controller.state
        for pose in BAD_POSES:
            with pytest.raises((InputError, TypeError)):
                controller.relocalise(*pose)
            assert controller.state == before
        for yaw, branch in ((0.464, 0), (math.pi - 0.464, 100)):
            _check_found(controller, yaw, branch)


def _check_found(controller: Any, yaw: float, branch: int) -> None:
    """The place is the branch's; of the rest of the state only what a jump makes wrong changes."""
    offset = controller.tracked_point
    before = controller.state.as_dict()
    pose = (-offset * math.cos(yaw), -offset * math.sin(yaw), yaw)
    controller.relocalise(*pose)
    after = controller.state.as_dict()
    # The place is the rear axle's, up to two segments before the crossing.
    assert (branch - after["place"]["segment"]) % 200 <= 2
    assert after["place"]["segment"] == CROSSING.relocalise(*pose)
    changed = {name for name, value in after.items() if value != before[name]}
    assert changed <= {"law", "place", "estimator", "monitor", "gate"}
    # The vehicle is looked for from there.
    assert after["place"]["lost"]
    assert after["gate"] is None
    assert after["estimator"]["last_measured"] is None
    controller.step(*pose, 5.0, 0.05)
    assert (controller.state.place.segment - branch + 1) % 200 <= 2
    assert not controller.state.place.lost


def test_law_of_any_wheelbase_weighs_the_heading_by_it() -> None:
    for wheelbase in (0.3, 2.7, 30.0):
        # There, and back a wheelbase and a half or four of them beside it.
        for apart, taken in ((1.5, 2), (4.0, 0)):
            xy = [(0.0, 0.0), (50.0, 0.0), (50.0, apart), (0.0, apart)]
            path = popsteer.Path([(wheelbase * x, wheelbase * y) for x, y in xy])
            controller = popsteer.Stanley(path, popsteer.Vehicle(wheelbase=wheelbase))
            controller.relocalise(25.0 * wheelbase, 0.0, math.pi)
            assert controller.state.place.segment == taken
            far = wheelbase * 10.0 / 3.0
            found = path.relocalise(25.0 * wheelbase, 0.0, math.pi, opposite_distance=far)
            assert found == taken


def test_law_whose_search_runs_out_of_its_budget_goes_on() -> None:
    # A circle from whose centre all is as far, and laps of which all are as near.
    whole = [math.tau * k / 70_000 for k in range(70_000)]
    lap = [math.tau * k / 600 for k in range(600)] * 117
    circle = popsteer.Path([(11e3 * math.cos(t), 11e3 * math.sin(t)) for t in whole], closed=True)
    laps = popsteer.Path([(95.0 * math.cos(t), 95.0 * math.sin(t)) for t in lap], closed=True)
    controller = popsteer.Stanley(circle, monitor=None)  # every pose is believed
    poses: Sequence[tuple[float, float, float]] = (
        (0.0, 0.0, 0.3),
        (4.0, -3.0, 2.0),
        (0.0, 0.1, -2.0),
    )
    # The first step goes on from the best place found, and a lost vehicle from its last place.
    for pose in poses:
        assert Status.OFF_PATH in controller.step(*pose, 5.0, 0.05).status
    controller.set_path(laps)
    places = []
    for pose in ((95.2, 0.3, 1.6), (-94.0, 0.2, -1.5), (0.0, 0.0, 0.0)):
        controller.step(*pose, 5.0, 0.05)
        places.append(controller.state.place.segment % 600)
    # Found, at the front axle, where the search has come near; at the centre nothing is near.
    assert abs(places[0] - 3) <= 1
    assert abs(places[1] - 303) <= 1
    assert abs(places[2] - 300) <= 20


@looped("rear_axle", [0.0, -1.35, -4.0, 2.0])
@looped("reference_offset", [3.0, 0.0, -1.5])
def test_follow_turns_round_by_the_rear_axle_whatever_point_the_pose_is_of(
    rear_axle: float, reference_offset: float
) -> None:
    # 40 m along x, 40 m back, 40 m along x again.
    xy = [(40.0 - abs(k % 80 - 40), 0.0) for k in range(121)]
    path = Path(xy, reverse=[40 <= k < 80 for k in range(121)])
    follow = Follow(
        base=0.0,
        reference_offset=reference_offset,
        rear_axle=rear_axle,
        search_distance=6.0,
        lost_distance=30.0,
        arrival_distance=0.15,
        opposite_distance=10.0,
    )

    def turned(last: int, rear: float, yaw: float, speed: float) -> bool:
        x, y = rear - rear_axle * math.cos(yaw), 0.2 - rear_axle * math.sin(yaw)
        vehicle = VehicleState(x, y, yaw, speed)
        return follow.locate(path, last, vehicle, 0.05, 0.05 * abs(speed)).direction_changed

    for yaw in (-0.1, 0.0, 0.2):
        for rear, is_there in ((39.7, False), (39.84, False), (39.86, True)):
            assert turned(38, rear, yaw, 0.3) is is_there
            assert turned(78, 40.0 - rear, yaw, -0.3) is is_there
