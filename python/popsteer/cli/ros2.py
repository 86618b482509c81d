"""``popsteer ros2``: a ROS 2 node that steers, without a ROS installation."""

from __future__ import annotations

from contextlib import ExitStack
from functools import partial
from typing import Annotated, Any

from popsteer._core import Driver, Vehicle
from popsteer.cli import inputs, options, ros2_options
from popsteer.cli.options import flag, valued
from popsteer.errors import printable
from popsteer.ranges import check_in_range

HELP = """\
Run a ROS 2 node that steers along the paths that a planner publishes, without ROS (extra 'ros2').

It takes odometry (/odom) and a path (/path), publishes commands (/drive) and diagnostics, and
stops where it has to: docs/ros2.md has its topics, services and when it stops. The odometry's pose
is that of the vehicle's point, from which its rear_axle is measured. Ctrl-C ends it.

\b
Examples:
  popsteer ros2 --vehicle car.toml --max-speed 3 --topic odometry=/ego/odom
  popsteer ros2 --vehicle car.toml --params tuned.toml --rate 100
  popsteer ros2 --vehicle car.toml --autoware --record drive.mcap
  popsteer ros2 --vehicle car.toml --ros-args -r __ns:=/car -p rate:=100.0
"""


def ros2(
    *,
    vehicle: Annotated[str, valued("NAME|FILE", "A file *.toml or a name.")],
    set_vehicle: options.SetVehicle = None,
    controller: Annotated[str, valued("NAME", "Who steers.")] = "preview-pop",
    preset: options.Preset = "default",
    params: options.Params = None,
    set_: options.Set = None,
    no_adapt: options.NoAdapt = False,
    max_speed: Annotated[float, valued("M/S", "Go no faster than this.")] = 5.0,
    rate: Annotated[float, valued("HZ", "Control steps a second.")] = 50.0,
    stale: Annotated[float, valued("SECONDS", "Steer by no older odometry.")] = 0.3,
    hold: Annotated[float, valued("SECONDS", "Then so long by dead reckoning.")] = 0.2,
    keep_path: Annotated[
        float, valued("SECONDS", "Keep a path so long where new ones are bad.")
    ] = 1.0,
    topic: ros2_options.Topic = None,
    path_type: ros2_options.PathType = None,
    command_type: ros2_options.CommandType = None,
    autoware: ros2_options.Autoware = False,
    sim_time: Annotated[bool, flag("--sim-time", "Time is that of the topic clock.")] = False,
    closed: Annotated[
        bool, flag("--closed", "The last point of each path joins its first.")
    ] = False,
    domain: ros2_options.Domain = None,
    localhost: ros2_options.Localhost = False,
    timeout: ros2_options.Timeout = 10.0,
    record: options.Record = None,
    ros_args: ros2_options.RosArgs = False,
    remap: ros2_options.Remap = None,
    param: ros2_options.Param = None,
    params_file: ros2_options.ParamsFile = None,
    log_level: ros2_options.LogLevel = None,
) -> None:
    """Run a ROS 2 node that steers, without ROS."""
    from popsteer.adapters.ros2.dds import Participant
    from popsteer.adapters.ros2.node import Node, Options
    from popsteer.adapters.ros2.pacing import spin, stop_on_signals
    from popsteer.adapters.ros2.recording import Recording

    given = inputs.believed(vehicle, set_vehicle)
    tuning = inputs.tuned(
        [controller],
        preset,
        set_,
        no_adapt=no_adapt,
        params=params,
        known=inputs.OWN_CONTROLLERS,
        own_too=False,
    )
    del ros_args  # the options after it say the same without it
    names = ros2_options.names_of(remap)
    topics = ros2_options.topics_of(topic, path_type, command_type, autoware=autoware, names=names)
    chosen: dict[str, Any] = {"rate": rate, "stale": stale, "hold": hold, "keep_path": keep_path}
    chosen |= {"timeout": timeout, "closed": closed, "max_speed": max_speed}
    chosen |= {"use_sim_time": sim_time, **ros2_options.parameters_of(param, params_file, names)}
    max_speed, sim_time = chosen.pop("max_speed"), chosen.pop("use_sim_time")
    settings = Options(**chosen, sim_time=sim_time, topics=topics)
    least = ros2_options.least(log_level)
    say: Any = lambda line: print(line, flush=True) if node.level >= least else None  # noqa: E731
    car, law = _limited(given, max_speed), tuning.params[controller]
    how: Any = {"adapt": tuning.adapt, "monitor": tuning.monitor}
    make: Any = partial(Driver, vehicle=car, controller=law, **how)
    stopped = stop_on_signals()
    with ExitStack() as stack:
        # First, so that it names the extra that is missing before a file is made.
        local, named = localhost or None, {"node": names.node, "namespace": names.namespace}
        participant = Participant(domain, local=local, **named)
        recording = None if record is None else stack.enter_context(Recording(record))
        node: Any = Node(participant, make, settings, recording=recording, say=say)
        what = f"{topics.odometry}, {topics.path} -> {topics.command} at {settings.rate:g} Hz"
        if least == 0:
            print(f"domain {participant.domain}: {what}", flush=True)
        spin(node, participant, stopped)
    loop, odometry, paths = node.loop, node.intake.odometry, node.intake.courses
    print(
        f"{loop.cycles} cycles, {loop.missed} missed; odometry: {odometry.received} messages,"
        f" {odometry.refused} refused; path: {paths.received}, {paths.refused} refused"
    )
    if recording is not None:
        print(f"Written to {printable(str(record))}: {recording.count} messages")


def _limited(vehicle: Vehicle, max_speed: float) -> Vehicle:
    check_in_range("--max-speed", max_speed, 0.0, 1e4, above=True)
    most = max_speed if vehicle.max_speed is None else min(vehicle.max_speed, max_speed)
    return vehicle.replace(max_speed=most)
