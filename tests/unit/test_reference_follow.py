"""What the reference's point of a vehicle does that no controller asks for yet."""

from __future__ import annotations

import math

from popsteer.reference import Path
from popsteer.reference.path.follow import Follow
from popsteer.reference.vehicle.state import VehicleState
from tests.helpers import looped


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
        return follow.locate(path, last, VehicleState(x, y, yaw, speed), 0.05).direction_changed

    for yaw in (-0.1, 0.0, 0.2):
        for rear, is_there in ((39.7, False), (39.84, False), (39.86, True)):
            assert turned(38, rear, yaw, 0.3) is is_there
            assert turned(78, 40.0 - rear, yaw, -0.3) is is_there
