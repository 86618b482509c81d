"""Where a controller finds its vehicle on the whole path: at the start, after a jump, when lost."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import pytest

import popsteer
from popsteer import InputError, Status
from tests.parity.laws import LATERAL, Law
from tests.parity.test_relocalise import BAD_POSES, figure_of_eight

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
    assert (branch - after["waypoint"]) % 200 <= 2
    assert after["waypoint"] == CROSSING.relocalise(*pose)
    changed = {name for name, value in after.items() if value != before[name]}
    assert changed <= {"waypoint", "measured_waypoint", "place", "estimator", "monitor"}
    assert (after["measured_waypoint"], after["place"]) == (None, None)
    assert after["estimator"]["last_measured"] is None
    controller.step(*pose, 5.0, 0.05)
    assert (controller.state.waypoint - branch + 1) % 200 <= 2


def test_law_of_any_wheelbase_weighs_the_heading_by_it() -> None:
    for wheelbase in (0.3, 2.7, 30.0):
        # There, and back a wheelbase and a half or four of them beside it.
        for apart, taken in ((1.5, 2), (4.0, 0)):
            xy = [(0.0, 0.0), (50.0, 0.0), (50.0, apart), (0.0, apart)]
            path = popsteer.Path([(wheelbase * x, wheelbase * y) for x, y in xy])
            controller = popsteer.Stanley(path, popsteer.Vehicle(wheelbase=wheelbase))
            controller.relocalise(25.0 * wheelbase, 0.0, math.pi)
            assert controller.state.waypoint == taken
            far = wheelbase * 10.0 / 3.0
            found = path.relocalise(25.0 * wheelbase, 0.0, math.pi, opposite_distance=far)
            assert found == taken


def test_law_whose_search_runs_out_of_its_budget_goes_on() -> None:
    # A circle from whose centre all is as far, and laps of which all are as near.
    whole = [math.tau * k / 70_000 for k in range(70_000)]
    lap = [math.tau * k / 600 for k in range(600)] * 117
    circle = popsteer.Path([(11e3 * math.cos(t), 11e3 * math.sin(t)) for t in whole], closed=True)
    laps = popsteer.Path([(95.0 * math.cos(t), 95.0 * math.sin(t)) for t in lap], closed=True)
    controller = popsteer.Stanley(circle)
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
        waypoint = controller.state.waypoint
        assert waypoint is not None
        places.append(waypoint % 600)
    # Found, at the front axle, where the search has come near; at the centre nothing is near.
    assert abs(places[0] - 3) <= 1
    assert abs(places[1] - 303) <= 1
    assert abs(places[2] - 300) <= 20
