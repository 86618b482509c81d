"""What the node does where something is missing, wrong or late; it is stepped by the test."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

import popsteer

pytest.importorskip("rosbags", reason='the extra "ros2" is not installed')
pytest.importorskip("cyclonedds", reason='the extra "ros2" is not installed')

from popsteer.adapters import ros2
from popsteer.adapters.ros2 import messages
from popsteer.adapters.ros2.dds import Participant
from popsteer.adapters.ros2.node import Node, Options
from tests.adapters.ros2_domain import PERIOD, Bench, domain
from tests.helpers import PATIENCE, looped

if TYPE_CHECKING:
    from collections.abc import Callable


@pytest.fixture
def bench() -> Bench:
    found = Bench()
    found.begin()
    return found


def test_node_without_anything_waits_and_says_for_what() -> None:
    bench = Bench()
    assert bench.cycle() is None
    assert bench.lines == ["waiting: no odometry on /odom"]
    assert bench.until(lambda: bench.reason == "no path on /path")
    report = bench.report()
    assert report["popsteer: steering"].level == 1
    assert report["popsteer: steering"].message == "waiting: no path on /path"


def test_node_publishes_commands_that_are_the_controllers(bench: Bench) -> None:
    bench.drive.take()
    bench.run(1)
    message = messages.decode(messages.ACKERMANN, bench.drive.take()[-1])
    drive = bench.node.drive
    assert drive is not None
    found = message.drive.steering_angle, message.drive.speed
    assert found == pytest.approx((drive.steer, drive.speed), rel=1e-6)
    assert message.header.stamp.sec * 10**9 + message.header.stamp.nanosec == bench.now
    assert message.header.frame_id == "base_link"


def test_path_in_another_frame_is_refused_counted_and_stopped_for(bench: Bench) -> None:
    bench.send_path(frame="odom")
    for _ in range(300):
        bench.run(1)
        if bench.state == "standing":
            break
    assert bench.state == "standing"
    said = "frame is 'map' of the odometry, 'odom' of the path"
    assert bench.reason == f"path on /path refused: {said}"
    values = bench.report()["values"]
    assert (values["path_refused"], values["path_refused_because"]) == ("1", said)
    bench.send_path()
    bench.run(5)
    assert bench.state == "driving"


def test_odometry_in_another_frame_is_refused_and_stopped_for(bench: Bench) -> None:
    bench.run(60, frame="odom")
    assert bench.state == "braking"
    assert "frame is 'odom' of the odometry, 'map' of the path" in bench.reason
    assert int(bench.report()["values"]["odometry_refused"]) > 50
    bench.run(3)
    assert bench.state == "driving"


def test_frame_that_both_have_changed_to_is_taken(bench: Bench) -> None:
    for _ in range(60):
        bench.cycle()
    bench.send_path(frame="odom")
    bench.run(5, frame="odom")
    assert bench.state == "driving"


def test_numbers_that_are_not_finite_are_refused_and_counted(bench: Bench) -> None:
    bench.x = float("nan")
    bench.send_pose()
    bench.x = 1.0
    points = ros2.path_message([0.0, 9.0], [0.0, float("inf")], [0.0, 0.0], 0, "map")
    bench.send(bench.path, points)
    bench.run(3)
    values = bench.report()["values"]
    assert values["odometry_refused_because"] == "x is nan"
    assert "got inf" in values["path_refused_because"]
    assert bench.state == "driving"


def test_path_that_cannot_be_used_leaves_the_last_one_in_force_for_a_time() -> None:
    bench = Bench(keep_path=0.5)
    bench.begin()
    empty = ros2.path_message([], [], [], 0, "map")
    nan = ros2.path_message([0.0, 9.0], [0.0, float("nan")], [0.0, 0.0], 0, "map")
    other = ros2.path_message([0.0, 9.0], [0.0, 0.0], [0.0, 0.0], 0, "odom")
    for bad in (empty, nan, other):
        bench.send(bench.path, bad)
        bench.run(24)
        assert bench.state == "driving"
        bench.send_path()
        bench.run(2)
    bench.send(bench.path, empty)
    bench.run(24)
    bench.send(bench.path, nan)  # time counts from the first
    bench.run(3)
    assert (bench.state, bench.reason[:22]) == ("holding", "path on /path refused:")


@pytest.mark.parametrize(
    ("seconds", "said"),
    [(-0.5, "stamp is 0.50 s old"), (0.2, "stamp is 0.20 s in the future")],
)
def test_stamp_of_another_clock_is_refused(bench: Bench, seconds: float, said: str) -> None:
    bench.run(5)
    for _ in range(30):
        bench.send_pose(at=bench.now + PERIOD + round(seconds * 1e9))
        bench.cycle()
    assert bench.state == "braking"
    assert bench.node.intake.odometry.reason == said


def test_odometry_slower_than_the_steps_is_no_stale_pose_though_clocks_differ(bench: Bench) -> None:
    bench.run(10, y=0.0)
    found = set()
    for k in range(90):
        if k % 3 == 0:
            bench.send_pose(y=0.0)
        bench.now += (-1) ** k * 300_000  # steps of 20 ms, by a steady clock
        drive = bench.cycle()
        assert drive is not None
        found.add(str(drive.status))
    assert found == {"ok"}


def test_stamps_in_another_order_are_refused(bench: Bench) -> None:
    bench.run(3)
    bench.send_pose(at=bench.now - 2 * PERIOD)
    bench.cycle()
    assert bench.node.intake.odometry.reason == "stamp is 0.020 s before the last one"
    assert bench.state == "driving"


def test_stamp_of_zero_counts_as_now() -> None:
    bench = Bench()
    bench.send_path()
    assert bench.until(lambda: bench.state == "driving", at=0)


@pytest.mark.parametrize("seconds", [-3600.0, 3600.0])
def test_time_that_jumps_is_said_held_through_and_gone_on_from(
    bench: Bench, seconds: float
) -> None:
    bench.run(10)
    bench.node.jumped(seconds)
    bench.now += round(seconds * 1e9)
    bench.cycle()
    assert bench.state == "holding"
    assert bench.lines[-1] == f"holding: time jumped by {seconds:+.2f} s"
    assert bench.report()["values"]["time_jumps"] == "1"
    bench.run(3)
    assert bench.state == "driving"


def test_new_path_is_gone_over_to(bench: Bench) -> None:
    bench.run(10)
    bench.send_path(y=1.0)
    bench.run(3)
    drive = bench.node.drive
    assert drive is not None
    assert drive.cross_track_error == pytest.approx(-0.9, abs=0.05)
    assert (bench.state, bench.node.intake.course_number) == ("driving", 2)


@pytest.mark.parametrize("seconds", [0.0, 0.15, 0.25])
def test_driver_is_told_how_old_the_pose_is(seconds: float) -> None:
    bench = Bench()
    bench.send_path()
    twin = bench.node._make(popsteer.Path([(float(x), 0.0) for x in range(0, 401, 5)]))
    at = bench.now + PERIOD - round(seconds * 1e9)
    assert bench.node.cycle(bench.now, 0.02) is None
    while bench.node.intake.course is None:
        bench.node.cycle(bench.now, 0.02)
    bench.send(bench.odometry, ros2.odometry_message(8.0, 0.1, 0.0, 4.0, at, "map"))
    wanted = twin.step(8.0, 0.1, 0.0, 4.0, 0.02, pose_age=seconds)
    found = bench.cycle()
    assert found is not None
    assert found.distance_to_stop == pytest.approx(wanted.distance_to_stop, abs=1e-6)
    assert found.distance_to_stop == pytest.approx(400.0 - 1.35 - 8.0 - 4.0 * seconds + 2.7, abs=2)
    assert found.steer == pytest.approx(wanted.steer, abs=1e-9)


def test_diagnostics_warn_while_something_is_wrong_and_no_longer(bench: Bench) -> None:
    other = Participant(bench.member.domain, local=True)
    name = "popsteer: inputs"
    bench.report()
    assert bench.report()[name].level == 0
    bench.send_pose(at=1)
    bench.run(1)
    assert bench.report()[name].message == "1 messages refused"
    assert bench.report()[name].message == "all messages used"
    bench.send_path(y=3.0)
    bench.run(1)
    assert bench.report()[name].message == "path jumped by 3.00 m"
    assert bench.report()[name].level == 0
    name = "popsteer: outputs"
    assert bench.report()[name].message == "heard"
    writer: Any = other.writer("/drive", messages.ACKERMANN)
    assert _until(lambda: bench.report()[name].message == "1 more publish on /drive")
    del writer
    assert _until(lambda: bench.report()[name].message == "heard")
    del bench.drive
    assert _until(lambda: bench.report()[name].message == "nobody hears /drive")


def test_clock_of_two_publishers_is_warned_of() -> None:
    bench = Bench(sim_time=True)
    bench.begin()
    others = [Participant(bench.member.domain, local=True) for _ in range(2)]
    clocks = [each.writer("/clock", messages.CLOCK) for each in others]
    said = "2 publishers of the clock"
    assert _until(lambda: bench.report()["popsteer: inputs"].message == said)
    clocks.pop()
    assert _until(lambda: bench.report()["popsteer: inputs"].level == 0)


def _until(holds: Callable[[], bool]) -> bool:
    until = time.monotonic() + PATIENCE
    while time.monotonic() < until:
        if holds():
            return True
        time.sleep(0.01)
    return False


def test_late_cycles_are_counted_and_reported(bench: Bench) -> None:
    bench.report()
    bench.now += 3 * PERIOD
    bench.node.cycle(bench.now, 0.06, 2)
    report = bench.report()
    assert report["popsteer: loop"].level == 1
    assert report["popsteer: loop"].message == "2 cycles missed"
    assert report["values"]["longest_period_s"] == "0.06"


def test_report_has_errors_deviation_and_estimates(bench: Bench) -> None:
    bench.run(30)
    report = bench.report()
    assert report["popsteer: steering"].level == 0
    assert report["popsteer: steering"].message == "driving"
    values = {name: float(report["values"][name]) for name in report["values"] if "_rad" in name}
    assert set(values) >= {"heading_error_rad", "estimated_steer_offset_rad"}
    assert float(report["values"]["cross_track_error_m"]) == pytest.approx(0.1, abs=0.01)
    assert float(report["values"]["deviation_m"]) == pytest.approx(0.1, abs=0.01)
    assert float(report["values"]["estimated_dead_time_s"]) == pytest.approx(0.1, abs=0.06)
    for y, greatest in ((0.6, 0.6), (0.1, 0.1)):  # since the last report
        bench.run(3, y=y)
        bench.run(1)
        assert float(bench.report()["values"]["deviation_m"]) == pytest.approx(greatest, abs=0.05)


def test_report_says_that_the_vehicle_stands_at_the_end_of_its_path(bench: Bench) -> None:
    bench.send_path(length=20.0)
    for _ in range(1000):
        bench.run(1, y=0.0)
        if bench.node.drive is not None and bench.node.drive.phase == "standing":
            break
    steering = bench.report()["popsteer: steering"]
    assert (steering.level, steering.message) == (0, "standing at its stop")
    bench.send_path(length=400.0)
    bench.run(20, y=0.0)
    assert bench.report()["popsteer: steering"].message == "driving"


def test_intended_trajectory_begins_at_the_vehicle(bench: Bench) -> None:
    topic = bench.node.options.topics.predicted
    reader = bench.member.reader(topic, messages.PATH, reliable=True)
    for _ in range(200):
        bench.run(6)
        if found := reader.take():
            break
    message = messages.decode(messages.PATH, found[-1])
    assert message.header.frame_id == "map"
    xs = [pose.pose.position.x for pose in message.poses]
    assert xs[0] == pytest.approx(bench.x, abs=1.0)
    assert 5.0 < xs[-1] - xs[0] < 10.0  # 2 s at 4 m/s


def _altered(random: np.random.Generator, data: bytes) -> bytes:
    """The message cut, or with bytes that are others."""
    if random.random() < 0.3:
        return data[: int(random.integers(0, len(data)))]
    changed = bytearray(data)
    for _ in range(int(random.integers(1, 30))):
        changed[int(random.integers(0, len(data)))] = int(random.integers(0, 256))
    return bytes(changed)


def test_thousand_messages_cut_or_altered_do_not_end_the_node(bench: Bench) -> None:
    random = np.random.default_rng(0)
    arrived, handed = 0, 0
    for k in range(1000):
        if k % 2:
            message: Any = ros2.odometry_message(bench.x, 0.1, 0.0, 4.0, bench.now, "map")
            writer, take = bench.odometry, bench.node.intake.take_odometry
        else:
            message = ros2.path_message([0.0, 90.0], [0.0, 0.0], [0.0, 0.0], k, "map")
            writer, take = bench.path, bench.node.intake.take_course
        data = _altered(random, messages.encode(message))
        try:  # over the wire, where DDS lets it through ...
            writer.write(data)
            arrived += 1
        except ValueError:  # ... and past it, where it does not
            take(data, 1e-9 * bench.now)
            handed += 1
        bench.now += PERIOD
        bench.node.cycle(bench.now, 0.02)
    assert arrived > 200
    assert handed > 200
    intake = bench.node.intake
    # The last few of a topic count where they came faster than they were taken.
    assert intake.odometry.received + intake.courses.received > 900
    assert intake.odometry.refused > 200
    assert intake.courses.refused > 100
    bench.send_path()
    bench.run(200)
    bench.node.release()  # what an altered pose has made of it
    assert bench.until(lambda: bench.state == "driving"), bench.reason


def test_refused_bytes_are_named_by_their_type(bench: Bench) -> None:
    assert not bench.node.intake.take_odometry(b"\x00\x01\x00\x00", 1.0)
    assert bench.node.intake.odometry.reason.startswith("is no nav_msgs/msg/Odometry")


@looped(
    ("options", "said"),
    [
        ({"rate": 0.5}, "rate must be in"),
        ({"stale": 2.0}, "stale must be in"),
        ({"hold": -1.0}, "hold must be in"),
        ({"timeout": float("nan")}, "timeout must be in"),
    ],
)
def test_option_out_of_its_range_is_refused(options: dict[str, float], said: str) -> None:
    with pytest.raises(popsteer.ConfigError, match=said):
        Options(**options)  # type: ignore[arg-type]


def test_wait_for_a_path_is_over_in_time_and_says_why() -> None:
    bench = Bench(timeout=0.5)
    assert bench.until(lambda: bench.reason == "no path on /path")
    wanted = r"^no nav_msgs/msg/Path that can be used on /path .*: its publisher sends nothing$"
    with pytest.raises(popsteer.PopsteerError, match=wanted):
        bench.node.check_silence(0.5)
    bench.send_path(frame="odom")
    assert bench.until(lambda: bench.node.intake.courses.refused == 1)
    with pytest.raises(popsteer.PopsteerError, match="1 of 1 messages refused, the last: frame is"):
        bench.node.check_silence(0.5)


def test_wait_is_over_in_time_and_says_what_is_known() -> None:
    member = Participant(domain(), local=True)
    alone = Node(member, popsteer.Driver, Options(timeout=0.5))
    alone.check_silence(0.4)
    with pytest.raises(
        popsteer.PopsteerError, match=r"on /odom in domain \d+ .*: nobody publishes"
    ):
        alone.check_silence(0.5)
    other = Participant(member.domain, local=True).writer("/odom", messages.PATH)
    until = time.monotonic() + PATIENCE
    while not member.graph.of("/odom") and time.monotonic() < until:
        member.graph.look()
        time.sleep(0.01)
    with pytest.raises(popsteer.PopsteerError, match="it is published as nav_msgs/msg/Path"):
        alone.check_silence(0.5)
    assert other.peers == 0
    bench = Bench(timeout=0.5)
    assert bench.until(lambda: bench.node.intake.odometry.refused > 0, at=1)
    with pytest.raises(popsteer.PopsteerError, match="simulated time needs --sim-time"):
        bench.node.check_silence(0.5)


def test_reports_go_on_after_each_time_that_the_clock_jumps_back() -> None:
    bench = Bench()
    for _ in range(3):
        bench.node.jumped(-100.0)
        bench.now -= 100 * 10**9
        bench.reports.take()
        for _ in range(60):
            bench.cycle()
        assert bench.reports.take()
