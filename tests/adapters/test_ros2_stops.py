"""How the node stops: for what is missing, for a fault, where it is told to, at the end."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest

import popsteer

pytest.importorskip("rosbags", reason='the extra "ros2" is not installed')
pytest.importorskip("cyclonedds", reason='the extra "ros2" is not installed')

from popsteer.adapters import ros2
from popsteer.adapters.ros2 import diagnostics, messages
from popsteer.adapters.ros2.topics import Topics
from tests.adapters.ros2_domain import PERIOD, SLOW, Bench, Client


@pytest.fixture
def bench() -> Bench:
    found = Bench()
    found.begin()
    return found


def _stop(bench: Bench) -> list[tuple[str, float]]:
    """Cycle without odometry until it stands: states and speeds."""
    found = []
    for _ in range(400):
        drive = bench.cycle()
        assert drive is not None
        found.append((bench.state, drive.speed))
        if bench.state == "standing":
            break
    return found


def test_stale_odometry_is_held_then_braked_to_a_stand_and_said() -> None:
    bench = Bench(stale=0.31, hold=0.21)
    bench.begin()
    bench.run(20)
    before = bench.node.drive
    assert before is not None
    states = _stop(bench)
    order = [state for state, _ in itertools.groupby(states, key=lambda each: each[0])]
    assert order == ["driving", "holding", "braking", "standing"]
    counts = {state: sum(1 for each in states if each[0] == state) for state in order}
    # The last pose was 20 ms old when it came.
    assert (counts["driving"], counts["holding"]) == (14, 10)
    held = [speed for state, speed in states if state == "holding"]
    assert held == pytest.approx([before.speed] * 10, abs=0.05)
    braked = [speed for state, speed in states if state in ("braking", "standing")]
    steps = -np.diff([held[-1], *braked])
    assert (steps >= 0.0).all()
    assert np.median(steps) == pytest.approx(0.06, abs=0.003)  # 3 m/s², in comfort
    assert braked[-1] == 0.0
    report = bench.report()
    assert report["popsteer: steering"].level == 2
    said = "standing: no odometry on /odom for 0.31 s"
    assert report["popsteer: steering"].message == said
    assert bench.lines[-1] == said
    bench.run(5)
    assert (bench.state, bench.lines[-1]) == ("driving", "driving")


def test_node_steers_on_from_the_angle_that_it_held(bench: Bench) -> None:
    bench.run(20)
    _stop(bench)
    assert bench.node.drive is not None
    held = bench.node.drive.steer
    bench.send_pose(speed=0.0)
    drive = bench.cycle()
    assert drive is not None
    assert drive.steer == pytest.approx(held, abs=0.03)
    assert 0.0 <= drive.speed <= 0.05


def faulty() -> Bench:
    """Two metres beside a path that it was on: as if the road were ice."""
    monitor = popsteer.MonitorParams(deviation_limit=0.5)
    bench = Bench(lambda path: popsteer.Driver(path, SLOW, monitor=monitor))
    bench.begin()
    bench.run(10)
    for _ in range(100):
        bench.run(1, y=2.0)
        if bench.state == "braking":
            break
    return bench


def test_fault_brakes_until_it_is_released() -> None:
    bench = faulty()
    assert bench.reason == "deviation"
    steering = bench.report()["popsteer: steering"]
    assert (steering.level, steering.message) == (2, "braking: deviation")
    bench.run(100, y=2.0)
    assert (bench.state, bench.reason) == ("standing", "deviation")
    bench.run(100, y=0.0)
    assert (bench.state, bench.reason, bench.speed) == ("standing", "deviation", 0.0)
    client = Client(bench.member, "/popsteer/reset")
    assert client.call(lambda: bench.run(1, y=0.0)) == (True, "released: deviation")
    bench.run(3, y=0.0)
    assert (bench.state, bench.reason) == ("driving", "")
    assert client.call(lambda: bench.run(1, y=0.0)) == (True, "there is no fault")


def test_fault_is_said_with_what_it_means_and_what_releases_it() -> None:
    bench = faulty()
    deviates = "deviation: it is farther off the path than its limit"
    assert bench.node.why == deviates
    end = "; ~/reset or a message on /popsteer/release releases it"
    assert bench.lines[-1] == f"braking: {deviates}{end}"
    driver = bench.node.driver
    assert driver is not None
    with pytest.raises(ValueError, match="fault must be one of") as caught:
        driver.state = driver.state.replace(fault="none")
    names = str(caught.value).split(" of ")[1].split(", got")[0].split(", ")
    assert {*names} - {"input"} == {*diagnostics.BLAMES}  # of which the reason is what is missing


def test_lines_have_the_level_of_what_they_say() -> None:
    bench = Bench()
    levels: list[tuple[str, int]] = []
    say = lambda line: levels.append((line.split(":")[0].split(" of")[0], bench.node.level))  # noqa: E731
    bench.node._say = say
    bench.run(1)
    bench.begin()
    _stop(bench)
    assert levels == [
        ("waiting", 1),
        ("path", 0),
        ("driving", 0),
        ("holding", 1),
        ("braking", 2),
        ("standing", 2),
    ]
    bench.begin_on()
    bench.run(50)
    bench.node.rest("the goal has ended")
    bench.run(120)
    assert levels[6:] == [("driving", 0), ("braking", 0), ("standing", 0)]


def test_vehicle_that_others_move_after_a_goal_is_no_fault(bench: Bench) -> None:
    bench.run(10)
    bench.node.rest("the goal has ended")
    bench.run(120)
    bench.drive.take()
    bench.run(200, y=5.0)  # farther than any limit: somebody drives it
    assert (bench.state, bench.reason) == ("standing", "the goal has ended")
    assert bench.drive.take() == []
    bench.send_path(y=5.0)
    bench.run(20, y=5.0)
    assert bench.state == "driving"


def test_fault_outlasts_lost_odometry_and_a_jump_of_time_and_is_released_where_it_is_back() -> None:
    bench = faulty()
    speeds = [bench.cycle().speed for _ in range(40)]  # type: ignore[union-attr]
    assert (np.diff(speeds) <= 0.0).all()
    assert (bench.state, bench.reason) == ("braking", "deviation")
    assert bench.node.release() == "released: deviation"
    _stop(bench)  # there is no odometry to drive by
    assert (bench.state, bench.speed) == ("standing", 0.0)
    bench.node.jumped(-5.0)
    bench.now -= 5 * 10**9
    bench.run(20, y=0.0)
    assert (bench.state, bench.reason) == ("driving", "")
    bench = faulty()
    bench.node.jumped(-5.0)
    bench.now -= 5 * 10**9
    bench.run(100, y=0.0)
    assert (bench.state, bench.reason) == ("standing", "deviation")


def test_car_that_cannot_stop_in_time_is_a_fault_and_an_error() -> None:
    bench = Bench()
    bench.send_path(length=20.0)
    bench.begin_on()
    hardest = 0.0
    for _ in range(300):
        bench.x += 0.02 * (4.0 - bench.speed)
        bench.speed = 4.0  # its brakes do nothing
        bench.run(1, y=0.0)
        message = messages.decode(messages.ACKERMANN, bench.drive.take()[-1])
        drive = bench.node.drive
        assert drive is not None
        assert message.drive.acceleration >= -drive.acceleration - 1e-6
        hardest = max(hardest, -drive.acceleration)
    assert (bench.state, bench.reason) == ("braking", "cannot-stop")
    assert hardest > 4.0
    steering = bench.report()["popsteer: steering"]
    assert (steering.level, steering.message) == (2, "braking: cannot-stop")


@pytest.mark.parametrize("kind", [messages.ACKERMANN, messages.CONTROL])
def test_acceleration_of_a_command_is_what_the_vehicle_may(kind: str) -> None:
    car = SLOW.replace(max_acceleration=1.0, max_deceleration=2.5)
    bench = Bench(
        lambda path: popsteer.Driver(path, car), topics=replace(Topics(), command_type=kind)
    )
    bench.speed = 0.0
    bench.begin()
    found = set()
    for k in range(160):
        if k == 100:
            bench.node.rest("the goal has ended")
        bench.run(1, y=0.0)
        drive = bench.node.drive
        assert drive is not None
        if not (taken := bench.drive.take()):
            assert bench.node.stands
            continue
        message = messages.decode(kind, taken[-1])
        if kind == messages.CONTROL:  # with its sign
            assert message.longitudinal.acceleration == pytest.approx(drive.acceleration, abs=1e-6)
            found.add(math.copysign(1.0, drive.acceleration))
        else:  # the most, with the reserve of the speed law
            wanted = max(2.9, -drive.acceleration) if drive.acceleration < 0.0 else 1.4
            assert message.drive.acceleration == pytest.approx(wanted)
            found.add(drive.acceleration < 0.0)
    assert len(found) == 2


def test_path_that_is_to_begin_waits_for_odometry_in_which_the_one_before_is_not_driven() -> None:
    bench = Bench(hold=2.0)
    bench.begin()
    bench.run(20)
    bench.node.rest("the goal has ended")
    bench.run(30)
    assert (bench.state, bench.reason) == ("braking", "the goal has ended")
    speeds = [bench.speed]
    for k in range(200):
        if k == 20:
            bench.send_path(y=0.5)
        bench.cycle()
        speeds.append(bench.speed)
    assert (np.diff(speeds) <= 0.0).all()
    assert (bench.state, bench.speed) == ("standing", 0.0)
    assert bench.node.waits == "no odometry on /odom for 0.3 s"
    bench.run(50)
    assert (bench.state, bench.node.waits) == ("driving", "")
    assert bench.node.drive is not None
    assert bench.node.drive.cross_track_error == pytest.approx(-0.4, abs=0.05)


@pytest.mark.parametrize("gap", [0.4, 0.7, 0.95, 3.0])
def test_vehicle_at_rest_is_no_fault_after_a_gap_of_odometry(gap: float) -> None:
    bench = Bench()
    bench.speed = 0.0
    bench.begin()
    for _ in range(20):
        bench.run(1, speed=0.01)
        bench.x = 2.0
    for _ in range(round(gap / 0.02)):
        bench.cycle()
        bench.x = 2.0
    bench.run(2, speed=0.0)
    assert (bench.state, bench.reason) == ("driving", "")


def test_speed_limit_that_changes_keeps_the_lap_and_the_drive() -> None:
    bench = Bench()
    bench.begin()
    bench.run(30)
    before, state = bench.node.drive, bench.node.driver and bench.node.driver.state
    assert before is not None
    bench.node.limit_speed(2.0)
    assert bench.node.driver is not None
    assert bench.node.driver.state == state
    bench.run(1)
    assert bench.node.drive is not None
    assert bench.node.drive.steer == pytest.approx(before.steer, abs=0.005)
    assert 0.0 <= before.speed - bench.node.drive.speed < 2.1
    bench.run(200, y=0.0)
    assert bench.speed == pytest.approx(2.0, abs=0.02)
    bench.node.limit_speed(float("inf"))
    bench.run(200, y=0.0)
    assert bench.speed == pytest.approx(4.0, abs=0.05)
    bench.node.change(hold=5.0)
    for _ in range(100):
        bench.cycle()
    assert bench.state == "holding"


def test_stale_and_keep_path_that_change_count_from_the_next_cycle_on(bench: Bench) -> None:
    bench.node.change(stale=0.1)
    bench.run(1)
    states = [(bench.cycle(), bench.state)[1] for _ in range(7)]
    assert states == ["driving"] * 4 + ["holding"] * 3  # the pose was 20 ms old when it came
    bench.run(5)
    for _ in range(3):
        bench.send_pose(at=bench.now + PERIOD - 200_000_000)
        bench.cycle()
    assert bench.node.intake.odometry.reason == "stamp is 0.20 s old"
    bench.node.change(stale=0.4)
    assert bench.until(lambda: bench.state == "driving")
    bench.run(3)
    for _ in range(14):
        bench.cycle()
    assert bench.state == "driving"

    bench.run(3)
    bench.node.change(keep_path=0.2)
    bench.send(bench.path, ros2.path_message([], [], [], 0, "map"))
    bench.run(9)
    assert bench.state == "driving"
    bench.run(4)
    assert (bench.state, bench.reason[:22]) == ("holding", "path on /path refused:")
    bench.node.change(keep_path=5.0)
    bench.run(20)
    assert bench.state == "driving"


def test_order_to_stand_is_no_excuse_for_a_fault(bench: Bench) -> None:
    bench.run(10)
    bench.node.intake.stand("the goal has ended")
    bench.run(120)
    steering = bench.report()["popsteer: steering"]
    assert (steering.level, steering.message) == (0, "standing: the goal has ended")
    driver = bench.node.driver
    assert driver is not None
    driver.state = driver.state.replace(fault="position")
    bench.run(3)
    steering = bench.report()["popsteer: steering"]
    assert (steering.level, steering.message) == (2, "standing: position")


def test_new_run_of_the_autonomous_state_releases_a_fault() -> None:
    bench = Bench(topics=replace(Topics(), mode="/vehicle/status/control_mode"))
    bench.begin()
    mode = bench.member.writer("/vehicle/status/control_mode", messages.CONTROL_MODE)
    driver = bench.node.driver
    assert driver is not None
    for obeys in (True, False, True):
        driver.state = driver.state.replace(fault="position")
        bench.send(mode, messages.make(messages.CONTROL_MODE, mode=1 if obeys else 4))
        bench.run(5)
        assert bench.state == ("driving" if obeys else "braking")
    driver.state = driver.state.replace(fault="position")
    bench.send(mode, messages.make(messages.CONTROL_MODE, mode=1))
    bench.run(5)
    assert bench.state == "braking"  # the same run goes on


def test_hand_over_in_mid_drive_begins_anew_after_a_fault() -> None:
    bench = Bench(topics=replace(Topics(), mode="/vehicle/status/control_mode"))
    bench.begin()
    mode = bench.member.writer("/vehicle/status/control_mode", messages.CONTROL_MODE)
    bench.send(mode, messages.make(messages.CONTROL_MODE, mode=4))
    bench.run(20)
    # A person drives at 4 m/s, in a bend and beside the path: not what is commanded.
    yaw, at = 0.0, [bench.x, 0.1]

    def driven(turn: float) -> None:
        nonlocal yaw
        yaw += 0.02 * turn
        at[0] += 0.08 * math.cos(yaw)
        at[1] += 0.08 * math.sin(yaw)
        sent = ros2.odometry_message(at[0], at[1], yaw, 4.0, bench.now, "map")
        bench.send(bench.odometry, sent)
        bench.cycle()

    for _ in range(150):
        driven(0.2)
    assert (bench.state, bench.node.level) == ("braking", 2)
    for _ in range(140):
        driven(-0.2)
    bench.send(mode, messages.make(messages.CONTROL_MODE, mode=1))
    for _ in range(10):
        driven(-0.2)
    assert bench.state == "driving"


def test_trajectory_without_any_speed_says_stand() -> None:
    bench = Bench(topics=Topics.of_autoware())

    def send(speed: float) -> None:
        points = [
            messages.make(
                "autoware_planning_msgs/msg/TrajectoryPoint",
                pose={"position": messages.make("geometry_msgs/msg/Point", x=x, y=0.1)},
                longitudinal_velocity_mps=speed,
            )
            for x in (0.0, 150.0)
        ]
        header = messages.make("std_msgs/msg/Header", frame_id="map")
        bench.send(bench.path, messages.make(messages.TRAJECTORY, header=header, points=points))

    bench.send_pose()
    send(0.0)
    assert bench.until(lambda: bench.state == "standing")
    bench.run(20)
    assert (bench.speed, bench.reason) == (0.0, "the path's speeds are 0")
    assert bench.report()["popsteer: steering"].level == 0  # so it is told to
    control = messages.decode(messages.CONTROL, bench.drive.take()[-1])
    assert (control.longitudinal.velocity, control.longitudinal.acceleration) == (0.0, -3.0)
    # In mid-drive, too, that is no stop which it overruns: it goes on as soon as it may.
    for _ in range(2):
        send(4.0)
        bench.run(60)
        assert bench.speed > 1.5
        send(0.0)
        assert bench.until(lambda: bench.state == "braking")
        assert bench.until(lambda: bench.state == "standing")
        assert (bench.reason, bench.node.level) == ("the path's speeds are 0", 0)


def test_last_command_is_to_stand_as_hard_as_the_vehicle_may() -> None:
    for kind in (messages.ACKERMANN, messages.CONTROL):
        bench = Bench(topics=replace(Topics(), command_type=kind))
        bench.node.finish(bench.now)
        assert not bench.drive.take()
        bench.begin()
        bench.run(5)
        last = bench.node.drive
        assert last is not None
        bench.drive.take()
        bench.node.finish(bench.now)
        said = messages.decode(kind, bench.drive.take()[-1])
        if kind == messages.ACKERMANN:
            found = said.drive.speed, said.drive.acceleration, said.drive.steering_angle
        else:
            moves = said.longitudinal
            found = moves.velocity, -moves.acceleration, said.lateral.steering_tire_angle
        assert found == pytest.approx((0.0, 3.4, last.steer), rel=1e-6), kind


@pytest.mark.parametrize("limit", [1e-9, 2e4])
def test_speed_limit_beyond_what_a_vehicle_can_have_is_kept(limit: float) -> None:
    bench = Bench(lambda path: popsteer.Driver(path, SLOW.replace(max_speed=None)))
    bench.begin()
    limits = bench.member.writer("/speed_limit", messages.SPEED_LIMIT)
    bench.send(limits, messages.make(messages.SPEED_LIMIT, speed_limit=limit))
    bench.run(150, y=0.0)
    slow = limit < 1.0
    assert (bench.speed < 0.05) == slow
    bench.node.rest("the goal has ended")
    bench.run(400, y=0.0)
    bench.send_path(y=0.01, length=900.0)  # which begins with the same limit
    bench.run(150, y=0.0)
    assert (bench.speed < 0.05) == slow
    assert bench.state == "driving"
