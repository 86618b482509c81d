"""What the ROS 2 node, its intake and its loop do next: after a path, a jump, a stop, a report."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

import popsteer
from popsteer import Status
from popsteer.adapters import ros2

pytest.importorskip("rosbags", reason='the extra "ros2" is not installed')
pytest.importorskip("cyclonedds", reason='the extra "ros2" is not installed')

from popsteer.adapters.ros2 import conversions, diagnostics, messages
from popsteer.adapters.ros2.commands import signed_speed
from popsteer.adapters.ros2.intake import Intake
from tests.adapters.ros2_domain import Bench

if TYPE_CHECKING:
    from pathlib import Path

DT = 0.02
CAR = popsteer.Vehicle(wheelbase=2.7, max_acceleration=1.0, max_deceleration=2.5)


def _path(shift: float = 0.0) -> popsteer.Path:
    x = np.arange(0.0, 200.0, 1.0)
    return popsteer.Path(np.column_stack((x, shift + 3.0 * np.sin(x / 12.0))), speed=0.0 * x + 6.0)


def _drive(events: dict[int, Any], steps: int = 400) -> np.ndarray:
    """Commands of a driver whose car obeys; at some steps something happens before."""
    driver = popsteer.Driver(_path(), CAR)
    plant = popsteer.sim.Simulation(
        _path(),
        popsteer.sim.KinematicBicycle(CAR),
        start=(0.0, 0.0, 0.24),
        speed=6.0,
        settings=popsteer.sim.Settings(dt=DT),
    )
    found, pedals = [], popsteer.SpeedPid()
    for k in range(steps):
        if k in events:
            events[k](driver)
        x, y, yaw, speed = plant.state
        drive = driver.step(x, y, yaw, speed, DT)
        found.append((drive.steer, drive.speed, drive.acceleration, speed))
        plant.step(drive.steer, *pedals.step(speed, drive.speed, DT))
    return np.array(found)


def test_path_sent_again_changes_no_command() -> None:
    plain = _drive({})
    again = _drive({k: lambda driver: driver.set_path(_path()) for k in (100, 150, 200, 201)})
    assert np.abs(plain[100:, 0]).max() > 0.02
    assert again == pytest.approx(plain, abs=1e-3)


def test_other_path_is_gone_over_to_without_a_jump_of_the_command() -> None:
    found = _drive({200: lambda driver: driver.set_path(_path(0.5))})
    plain = _drive({})
    usual = np.abs(np.diff(plain[:200, 0])).max()
    assert abs(found[200, 0] - found[199, 0]) < usual + 0.03
    assert found[200:, 1] == pytest.approx(plain[200:, 1], abs=0.1)
    assert np.abs(found[205:260, 0] - plain[205:260, 0]).max() > 0.01


def test_jump_of_time_goes_on_from_the_angle_and_the_speed_that_there_are() -> None:
    bench = Bench()
    bench.begin()
    bench.run(15, y=0.6)
    before = bench.node.drive
    assert before is not None
    assert before.steer < -0.05
    bench.node.jumped(-3.0)
    bench.now -= 3 * 10**9
    bench.run(1, y=0.6)
    drive = bench.node.drive
    assert drive is not None
    assert drive.steer == pytest.approx(before.steer, abs=0.5 * DT + 1e-6)
    assert drive.speed == pytest.approx(before.speed, abs=0.1)
    assert bench.state == "driving"


def test_each_interruption_is_held_for_the_whole_time_and_no_longer() -> None:
    bench = Bench(stale=0.03, hold=0.11)
    bench.begin()
    bench.run(60, y=0.0)
    for _ in range(3):
        bench.run(2, y=0.0)
        speed = bench.speed
        for _ in range(5):
            bench.cycle()
            assert bench.state == "holding"
            assert bench.speed == pytest.approx(speed, abs=0.05)
        bench.run(1, y=0.0)
        assert bench.state == "driving"
    for _ in range(6):
        bench.cycle()
    assert bench.state == "braking"


def test_commanded_speed_is_within_the_plan_and_what_the_car_can_reach() -> None:
    for sign in (1.0, -1.0):
        xy = sign * np.column_stack((np.arange(0.0, 90.0), np.zeros(90)))
        path = popsteer.Path(xy, speed=np.full(90, sign * 4.0))
        # A car that rolls on at 8 m/s is told the plan's speed; one that stands still, what its
        # acceleration of 1 m/s² gives in the drive's delay of 0.1 s and half a second.
        for measured, wanted in ((8.0, 4.0), (0.0, 0.6)):
            driver = popsteer.Driver(path, CAR, popsteer.StanleyParams())
            for k in range(100):
                place = sign * measured * DT * k
                drive = driver.step(place, 0.0, 0.0, sign * measured, DT)
            assert signed_speed(drive) == pytest.approx(sign * wanted), (sign, measured)


def test_intake_takes_stamps_in_order_and_the_same_one_twice() -> None:
    intake = Intake(messages.PATH, stale=0.3)

    def take(stamp: float, now: float, x: float = 0.0) -> bool:
        message = conversions.odometry_message(x, 0.0, 0.0, 4.0, round(stamp * 1e9), "map")
        return intake.take_odometry(messages.encode(message), now)

    assert take(8.0, 8.01, 1.0)
    assert take(8.0, 8.02, 2.0)
    assert intake.measured is not None
    assert intake.measured_at == 8.0
    assert intake.measured.x == 2.0
    assert not take(7.999, 8.03)
    assert not take(8.1, 8.04)
    assert take(8.05, 8.04)
    # What is stamped a little ahead was measured now.
    assert intake.measured_at == 8.04
    assert intake.odometry_refused == ""
    assert (intake.odometry.received, intake.odometry.refused) == (5, 2)
    assert "0.06 s in the future" in intake.odometry.reason
    assert take(8.10, 8.395)
    assert not take(8.15, 8.455)
    # After a jump of the clock an earlier stamp is taken.
    intake.forget_odometry()
    assert take(5.0, 5.0)


def test_loop_counts_all_cycles_and_measures_since_the_last_report() -> None:
    loop = diagnostics.Loop(0.02)
    for period, taken, missed in ((0.02, 0.001, 0), (0.05, 0.004, 1), (0.02, 0.002, 0)):
        loop.count(period, taken, missed)
    assert (loop.cycles, loop.missed, loop.missed_lately) == (3, 1, 1)
    assert loop.mean_period == pytest.approx(0.03)
    assert (loop.longest_period, loop.longest_step) == (0.05, 0.004)
    loop.begin()
    loop.count(0.025, 0.003, 2)
    assert (loop.cycles, loop.missed, loop.missed_lately) == (4, 3, 2)
    assert (loop.mean_period, loop.longest_period, loop.longest_step) == (0.025, 0.025, 0.003)


def _values(message: Any, name: str = "steering") -> dict[str, str]:
    (status,) = [each for each in message.status if each.name == f"popsteer: {name}"]
    return {each.key: each.value for each in status.values}


def test_refused_messages_warn_in_the_next_report_and_no_longer() -> None:
    bench = Bench()
    bench.begin()
    x, bench.x = bench.x, math.nan
    bench.send_pose()
    bench.x = x
    bench.send(bench.path, ros2.path_message([0.0, 9.0], [0.0, math.inf], [0.0, 0.0], 0, "map"))
    refused = bench.node.intake.odometry, bench.node.intake.courses
    assert bench.until(lambda: all(each.refused == 1 for each in refused))
    bench.send_path()
    assert bench.until(lambda: not bench.node.intake.course_refused)
    bench.report()
    bench.send_pose()
    inputs = bench.report()["popsteer: inputs"]
    assert (inputs.level, inputs.message) == (0, "all messages used")


def test_diagnostics_say_what_the_command_says_in_its_units() -> None:
    driver = popsteer.Driver(_path(), CAR)
    intake, loop = Intake(messages.PATH, stale=0.3), diagnostics.Loop(0.02)
    data = conversions.odometry_message(0.5, 0.3, 0.5, 5.0, 10**9, "map")
    assert intake.take_odometry(messages.encode(data), 1.0)
    assert intake.measured is not None
    drive = driver.step(*intake.measured[:4], DT)
    loop.count(0.03, 0.004, 2)
    known: dict[str, Any] = {
        "state": "driving",
        "reason": "",
        "level": 0,
        "deviation": 0.75,
        "path_jump": 4.0,
        "nanoseconds": 1_250_000_000,
    }
    around: dict[str, Any] = {"command": "/drive", "listeners": 3, "rivals": 1, "clocks": 2}
    made = diagnostics.message(loop, intake, driver, drive, **known, **around)
    estimate = driver.estimate
    assert abs(drive.heading_error) > 0.2
    expected = {
        "cross_track_error_m": drive.cross_track_error,
        "heading_error_rad": drive.heading_error,
        "predicted_cross_track_error_m": drive.predicted_cross_track_error,
        "predicted_heading_error_rad": drive.predicted_heading_error,
        "deviation_m": 0.75,
        "distance_to_stop_m": drive.distance_to_stop,
        "steer_rad": drive.steer,
        "speed_mps": drive.speed,
        "estimated_dead_time_s": estimate.dead_time,
        "estimated_steer_offset_rad": estimate.steer_offset,
        "estimated_gain": estimate.gain,
        "estimated_slip_rad": estimate.slip,
    }
    said = _values(made)
    for name, value in expected.items():
        assert float(said[name]) == pytest.approx(value, rel=1e-5), name
    assert float(_values(made, "inputs")["odometry_age_s"]) == pytest.approx(0.25)
    times = _values(made, "loop")
    assert (times["mean_period_s"], times["longest_step_s"]) == ("0.03", "0.004")
    assert (times["cycles"], times["missed_cycles"]) == ("1", "2")
    statuses = {each.name: (each.level, each.message) for each in made.status}
    assert statuses["popsteer: loop"] == (1, "2 cycles missed")
    assert statuses["popsteer: inputs"][0] == statuses["popsteer: outputs"][0] == 1
    assert "2 publishers of the clock" in statuses["popsteer: inputs"][1]
    assert "path jumped by 4.00 m" in statuses["popsteer: inputs"][1]
    assert _values(made, "outputs") == {"command_subscribers": "3", "other_publishers": "1"}
    assert made.header.stamp.sec == 1


@pytest.mark.parametrize("status", [Status.OK, Status.SATURATED, Status.DEVIATING])
def test_run_message_has_radians_and_the_level_of_its_status(status: Status) -> None:
    row = {"cross_track_error": -0.25, "heading_error": 0.5, "steer": -0.1, "status": int(status)}
    made = diagnostics.run_message(row, 0)
    assert _values(made) == {
        "cross_track_error_m": "-0.25",
        "heading_error_rad": "0.5",
        "steer_rad": "-0.1",
    }
    level = {"ok": 0, "degraded": 1, "fault": 2}[status.level]
    assert (made.status[0].level, made.status[0].message) == (level, str(status))


def test_recording_of_a_run_is_read_back_to_every_column(tmp_path: Path) -> None:
    from rosbags.highlevel import AnyReader

    from popsteer import logs
    from popsteer.logs.messages import typestore

    car = CAR.replace(rear_axle=-1.35)
    run = popsteer.sim.run(
        popsteer.Stanley(_path(), car), popsteer.sim.KinematicBicycle(car), constant_speed=6.0
    )
    file = tmp_path / "run.mcap"
    count = ros2.record_run(run, file)
    steps = len(run.records["time"])
    assert count == 3 * steps + 1
    log = logs.read(file)
    for name in ("x", "y", "speed"):
        assert log.as_dict()[name] == pytest.approx(run.records[name], abs=1e-9), name
    assert log.t == pytest.approx(run.records["time"], abs=1e-6)
    turned = np.remainder(log.yaw - run.records["yaw"] + math.pi, math.tau) - math.pi
    assert turned == pytest.approx(np.zeros(steps), abs=1e-9)
    assert log.steer == pytest.approx(run.records["steer"], abs=1e-7)
    # Each pose of the path points along the segment that begins there, the last as the one before.
    with AnyReader([file], default_typestore=typestore()) as reader:
        said = [
            (connection.msgtype, reader.deserialize(data, connection.msgtype))
            for connection, _, data in reader.messages()
        ]
    # With no limit of the acceleration, which a simulated run does not know.
    drives = [message for kind, message in said if kind == messages.ACKERMANN]
    assert [each.drive.acceleration for each in drives] == [0.0] * steps
    assert [each.drive.speed for each in drives] == pytest.approx(run.records["speed"], abs=1e-6)
    (found,) = (message for kind, message in said if kind == messages.PATH)
    path = _path()
    headings = np.arctan2(np.diff(path.y), np.diff(path.x))
    yaws = [conversions.yaw_of(pose.pose.orientation) for pose in found.poses]
    assert yaws == pytest.approx([*headings, headings[-1]])
    assert [pose.pose.position.y for pose in found.poses] == pytest.approx(path.y)


def _interrupted(file: Path, count: int) -> None:
    with ros2.Recording(file) as recording:
        for k in range(count):
            at = 10**9 + 10**8 * k
            pose = conversions.odometry_message(float(k), 0.0, 0.0, 1.0, at, "map")
            drive = conversions.ackermann_message(0.1 * k, 1.0, 0.0, at, "base_link")
            recording.add("/odom", pose, at)
            recording.add("/drive", drive, at)
        raise RuntimeError("in mid-drive")


def test_recording_keeps_what_came_before_an_exception(tmp_path: Path) -> None:
    from popsteer import logs

    for count in (0, 5):
        with pytest.raises(RuntimeError, match="in mid-drive"):
            _interrupted(tmp_path / f"{count}.mcap", count)
    assert [each.name for each in tmp_path.iterdir()] == ["5.mcap"]
    log = logs.read(tmp_path / "5.mcap")
    assert log.x.tolist() == [0.0, 1.0, 2.0, 3.0, 4.0]
    assert log.steer == pytest.approx([0.0, 0.1, 0.2, 0.3, 0.4])
