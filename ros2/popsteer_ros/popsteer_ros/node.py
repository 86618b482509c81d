"""The lifecycle node: popsteer's own node, with parameters, tf and time of rclpy."""

from __future__ import annotations

import time
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path as FilePath
from typing import Any

import rclpy
from rcl_interfaces.msg import FloatingPointRange, ParameterDescriptor, SetParametersResult
from rclpy.clock import Clock, ClockType
from rclpy.executors import SingleThreadedExecutor
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.lifecycle import LifecycleNode, TransitionCallbackReturn
from rclpy.signals import SignalHandlerOptions

from popsteer import ConfigError, Driver, Path, PopsteerError, Vehicle, controllers, vehicles
from popsteer.adapters.ros2 import Node, Options, Recording, Topics
from popsteer.adapters.ros2.diagnostics import ERROR, OK, WARN
from popsteer.adapters.ros2.node import RANGES
from popsteer.adapters.ros2.pacing import Pace, frozen, stop_on_signals
from popsteer.adapters.ros2.topics import COMMANDS
from popsteer.cli.inputs import tuned
from popsteer.sim.geometry import check_length

from .frames import Frames
from .transport import Transport

# Name: default, what, range; for popsteer's own options, default and range are theirs.
PARAMETERS: dict[str, tuple[Any, ...]] = {
    "rate": (Options.rate, "steps a second at most, and where no odometry comes [Hz]"),
    "stale": (Options.stale, "odometry older than this is not steered by [s]"),
    "hold": (Options.hold, "how long it drives on without what is missing before it brakes [s]"),
    "keep_path": (Options.keep_path, "how long a path stays where later ones are refused [s]"),
    "timeout": (Options.timeout, "how long a goal waits for odometry and transforms [s]"),
    "tf_stale": (1.0, "a moving transform older than this is not used [s]", 0.01, 1e6),
    "max_speed": (5.0, "go no faster than this [m/s]", 0.01, 1e4),
    "goal_tolerance": (0.25, "a goal is reached this near to the path's end [m]", 0.001, 100.0),
    "progress_distance": (0.5, "progress is to come nearer to the end by this [m]", 0.0, 100.0),
    "progress_time": (10.0, "a goal without progress is aborted after this [s]", 0.1, 1e6),
    "controller_plugins": (["FollowPath"], "names of controllers that goals may ask for"),
    "autostart": (False, "whether the process configures and activates the node at once"),
    "bond": (True, "whether Nav2's lifecycle manager is told that the node lives"),
    "vehicle": ("", "the vehicle: a file *.toml or a name"),
    "controller": ("preview-pop", "the controller"),
    "preset": ("default", "its preset"),
    "params": ("", "its parameters: a file *.toml as popsteer tune writes it"),
    "set": ([""], "single parameters of it, and how it adapts: NAME=VALUE each"),
    "adapt": (True, "whether it adapts to the vehicle"),
    "monitor": (True, "whether deviating from the path and implausible turns are faults"),
    "command_type": ("", f"what is published: {', '.join(COMMANDS)}; ackermann if empty"),
    "base_frame": ("", "frame of the vehicle's point; the odometry's child frame if empty"),
    "rear_axle_frame": ("", "frame of the rear axle: its place in base_frame is used"),
    "path_file": ("", "a path as popsteer.Path.from_csv reads it"),
    "path_columns": ("", "what the columns of path_file are, as x,y,-,speed; empty: their names"),
    "path_frame": ("map", "frame of path_file"),
    "closed": (Options.closed, "whether the last point of a path joins its first"),
    "steering": ("", "a topic with the wheels' angle as it is measured (AckermannDriveStamped)"),
    "record": ("", "a file *.mcap that all messages are written to while it is active"),
    "autoware": (False, "Autoware's topics and messages"),
}
CHANGED = ("stale", "hold", "keep_path")  # of popsteer's options, while it drives
LIVE = {*CHANGED, "tf_stale", "max_speed", "goal_tolerance", "progress_distance", "progress_time"}
_LAST = 1.0  # how long the results of goals have to go out when the process ends [s]


class Track(LifecycleNode):
    """Steers along paths; in its state "active" alone."""

    def __init__(self, **options: Any) -> None:
        super().__init__("popsteer", **options)
        for name, (default, what, *limits) in PARAMETERS.items():
            described = ParameterDescriptor(description=what)
            if range_ := limits or RANGES.get(name):
                limit = FloatingPointRange(from_value=range_[0], to_value=range_[1])
                described.floating_point_range = [limit]
            self.declare_parameter(name, default, described)
        self.core: Node | None = None
        self.frames: Frames | None = None
        self.follow: Any = None
        self._link: Transport | None = None
        self._came = False
        self.add_on_set_parameters_callback(self._check)
        self.add_post_set_parameters_callback(self._change)
        asked = self._service_change_state.callback
        self._service_change_state.callback = lambda *given: self._asked(asked, *given)

    def value(self, name: str) -> Any:
        """Give a parameter."""
        return self.get_parameter(name).value

    def now(self) -> int:
        """Give the time of the node's clock [ns]."""
        return int(self.get_clock().now().nanoseconds)

    def _asked(self, change: Any, request: Any, response: Any) -> Any:
        """Change the state as a service asks for; refuse what cannot be, which rclpy does not."""
        try:
            return change(request, response)
        except rclpy_implementation.RCLError:
            wanted = request.transition.label[:99] or request.transition.id
            state = self._state_machine.current_state[1]
            self.get_logger().error(f"transition {wanted} is refused in the state {state}")
            response.success = False
            return response

    def on_configure(self, _: Any) -> TransitionCallbackReturn:
        """Check what is given, hear tf, and offer the action."""
        if said := self._load({}):
            self.get_logger().error(said)
            return TransitionCallbackReturn.FAILURE
        self.frames = Frames(self, self.value("tf_stale"))
        try:
            from .follow_path import Follow

            self.follow = Follow(self)
        except ImportError:
            self.get_logger().info("no nav2_msgs: the action follow_path is not offered")
        return TransitionCallbackReturn.SUCCESS

    def on_activate(self, state: Any) -> TransitionCallbackReturn:
        """Hear odometry and paths, and steer."""
        try:
            self._start()
        except (PopsteerError, OSError, RuntimeError, ValueError) as error:
            self.get_logger().error(f"not activated: {error}")
            self.stop("the activation has failed")
            return TransitionCallbackReturn.FAILURE
        return super().on_activate(state)

    def _start(self) -> None:
        make, path = self._named
        self._link = Transport(self, lambda: self._tick(came=True))
        topics = self._topics()
        given = {name: self.value(name) for name in (*CHANGED, "rate", "timeout", "closed")}
        options = Options(**given, topics=topics)
        file = self.value("record")
        recording = self._link.enter_context(Recording(file)) if file else None
        self.core = Node(self._link, make, options, recording=recording, say=self._say)
        self.frames.base, self.frames.axle = self.value("base_frame"), self.value("rear_axle_frame")
        self.frames.known = {}
        self.frames.clear()  # time may have begun anew since it was active
        self.core.intake.frames = self.frames
        self.core.limit_speed(self.value("max_speed"))
        if path is not None:
            self.core.intake.use(path, self.value("path_frame"))
        if self.follow is not None:
            self.follow.core = self.core
        if self.value("bond") and find_spec("bond") is not None:
            from . import heartbeat

            heartbeat.begin(self, self._link)
        self._link.enter_context(frozen())
        # Periods are those of a steady clock, or of the simulation's.
        simulated = self.value("use_sim_time")
        clock = self.get_clock() if simulated else Clock(clock_type=ClockType.STEADY_TIME)
        self._passed = lambda: int(clock.now().nanoseconds)
        self._pace = Pace(round(options.period * 1e9), self._passed(), self.now())
        self._timer = self.create_timer(options.period, self._tick, clock=clock)
        self._link.callback(self.destroy_timer, self._timer)

    def _say(self, line: str) -> None:
        """Log what the core tells, by how bad it is."""
        level = OK if self.core is None else self.core.level
        logger = self.get_logger()
        # Each in a place of its own: rclpy takes one severity at each.
        if level == ERROR:
            logger.error(line)
        elif level == WARN:
            logger.warning(line)
        else:
            logger.info(line)

    def _topics(self) -> Topics:
        """Give the topics, by the names that they are remapped to."""
        topics = Topics.of_autoware() if self.value("autoware") else Topics()
        if find_spec("nav2_msgs") is None:
            topics = replace(topics, speed_limit="")
        if sent := self.value("command_type"):
            topics = replace(topics, command_type=COMMANDS[sent])
        measured = {"steering": name} if (name := self.value("steering")) else {}
        topics = topics.renamed(measured, self.get_name(), self.get_namespace())
        return topics.renamed({k: self.resolve_topic_name(v) for k, v in topics.names().items()})

    def on_deactivate(self, state: Any) -> TransitionCallbackReturn:
        """Command to stand, and hear no more."""
        self.stop()
        return super().on_deactivate(state)

    def on_cleanup(self, _: Any) -> TransitionCallbackReturn:
        """Command to stand, and forget tf."""
        self.stop("the node is shut down")
        if self.frames is not None:
            self.frames.close()
            self.frames = None
        if self.follow is not None:
            self.follow.close()
            self.follow = None
        return TransitionCallbackReturn.SUCCESS

    on_shutdown = on_cleanup

    def stop(self, why: str = "the node is deactivated") -> None:
        """Command to stand, and take away what activating has made."""
        if self._link is None:
            return
        if self.core is not None:
            if self.follow is not None:
                self.follow.stop(why)
            self.core.finish(self.now())
        self._link.close()
        self.core = self._link = None

    def _load(self, new: dict[str, Any]) -> str:
        """Load what the parameters name, some of which are new; says what is wrong with them."""
        given = {name: new.get(name, self.value(name)) for name in PARAMETERS}
        name, file, sent = given["vehicle"], given["path_file"], given["command_type"]
        try:
            car = (Vehicle.load if name.endswith(".toml") else vehicles.get)(name)
            if sent and sent not in COMMANDS:
                raise ConfigError.unknown("command_type", sent, COMMANDS)
            columns = given["path_columns"] or None
            path = Path.from_csv(file, closed=given["closed"], columns=columns) if file else None
            if path is not None:
                check_length(path, car, file)
                self.get_logger().info(f"read {path.source}")
            kind = given["controller"]
            tuning = tuned(
                [kind],
                given["preset"],
                [each for each in given["set"] if each],
                no_adapt=not given["adapt"],
                params=FilePath(given["params"]) if given["params"] else None,
                known=controllers.names(),
            )
        except (PopsteerError, OSError) as error:
            return str(error)
        monitor = tuning.monitor if given["monitor"] else None
        chosen = {"controller": tuning.params[kind], "adapt": tuning.adapt, "monitor": monitor}

        # What tf knows of the vehicle is not there before the first path.
        self._named = lambda path: Driver(path, car.replace(**self.frames.known), **chosen), path
        return ""

    def _tick(self, *, came: bool = False) -> None:
        """Step on the odometry, or by the timer where it stays away, as `spin` does."""
        if self.core is None:
            return
        self._came |= came
        if self._pace.cycle(self.core, self._passed(), self.now(), came=self._came):
            self._came = False
            if self.follow is not None:
                self.follow.check()
        next_one = self._pace.earliest if self._came else self._pace.due
        self._timer.timer_period_ns = max(next_one - self._passed(), 1_000_000)
        self._timer.reset()

    def _check(self, parameters: list[Any]) -> SetParametersResult:
        """Refuse what only a new start can take, and what cannot be."""
        new = {each.name: each.value for each in parameters}
        late = sorted(new.keys() & PARAMETERS.keys() - LIVE) if self.core is not None else []
        said = f"{', '.join(late)} can be changed while the node is inactive" if late else ""
        # Others that are declared, as overrides of a QoS, load nothing anew.
        if self.core is None and self.frames is not None and new.keys() & PARAMETERS.keys():
            said = self._load(new)
        return SetParametersResult(successful=not said, reason=said)

    def _change(self, parameters: list[Any]) -> None:
        """Take what the parameters are now."""
        if self.frames is None or not {each.name for each in parameters} & PARAMETERS.keys():
            return
        self.frames.stale = self.value("tf_stale")
        if self.core is None:
            self._load({})
        else:
            self.core.change(**{name: self.value(name) for name in CHANGED})
            self.core.limit_speed(self.value("max_speed"))


def main() -> None:
    """Run the node until SIGINT or SIGTERM; it stands until it is activated."""
    # rclpy's own handlers would take the publishers away before the last command.
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    stopped = stop_on_signals()
    node, executor = Track(), SingleThreadedExecutor()
    executor.add_node(node)
    try:
        if node.value("autostart"):
            node.trigger_configure()
            if node.frames is not None:
                node.trigger_activate()
        while not stopped():
            executor.spin_once(timeout_sec=0.1)
    finally:
        node.stop("the process ends")
        until = time.monotonic() + _LAST
        while node.follow is not None and node.follow.open and time.monotonic() < until:
            executor.spin_once(timeout_sec=0.01)
        executor.spin_once(timeout_sec=0.01)  # in which the last result goes out
        node.destroy_node()
        rclpy.shutdown()
