"""The lifecycle node: popsteer's own node, with parameters, tf and time of rclpy."""

from __future__ import annotations

import gc
import math
import signal
import threading
from typing import Any

import rclpy
from rcl_interfaces.msg import FloatingPointRange, ParameterDescriptor, SetParametersResult
from rclpy.clock import Clock, ClockType
from rclpy.executors import SingleThreadedExecutor
from rclpy.lifecycle import LifecycleNode, TransitionCallbackReturn
from rclpy.signals import SignalHandlerOptions

from popsteer import ConfigError, PopsteerError, Vehicle, controllers, vehicles
from popsteer.adapters.ros2 import Node, Options, Topics
from popsteer.adapters.ros2.intake import load_path
from popsteer.adapters.ros2.node import RANGES
from popsteer.adapters.ros2.pacing import Pace
from popsteer.adapters.ros2.topics import COMMANDS

from .frames import Frames
from .transport import Transport

# Name: default, what, range; for popsteer's own options, default and range are theirs.
PARAMETERS: dict[str, tuple[Any, ...]] = {
    "rate": (Options.rate, "steps a second at most, and where no odometry comes [Hz]"),
    "stale": (Options.stale, "odometry older than this is not steered by [s]"),
    "hold": (Options.hold, "how long the last command is held before it brakes [s]"),
    "keep_path": (Options.keep_path, "how long a path stays where later ones are refused [s]"),
    "timeout": (Options.timeout, "how long a goal waits for odometry and transforms [s]"),
    "tf_stale": (1.0, "a moving transform older than this is not used [s]", 0.01, 1e6),
    "max_speed": (5.0, "go no faster than this [m/s]", 0.01, 1e4),
    "goal_tolerance": (0.25, "a goal is reached this near to the path's end [m]", 0.001, 100.0),
    "progress_distance": (0.5, "progress is to come nearer to the end by this [m]", 0.0, 100.0),
    "progress_time": (10.0, "a goal without progress is aborted after this [s]", 0.1, 1e6),
    "vehicle": ("", "the vehicle: a file *.toml or a name"),
    "controller": ("preview-pop", "the controller"),
    "command_type": ("ackermann", f"what is published: {', '.join(COMMANDS)}"),
    "base_frame": ("", "frame of the vehicle's point; the odometry's child frame if empty"),
    "rear_axle_frame": ("", "frame of the rear axle: its place in base_frame is used"),
    "path_file": ("", "a path as CSV: x, y, speed; or a raceline s; x; y; psi; kappa; vx; ax"),
    "path_frame": ("map", "frame of path_file"),
    "closed": (Options.closed, "whether the last point of a path joins its first"),
    "autoware": (False, "Autoware's topics and messages"),
}
CHANGED = ("stale", "hold", "keep_path")  # of popsteer's options, while it drives
LIVE = {*CHANGED, "tf_stale", "goal_tolerance", "progress_distance", "progress_time"}


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
        self._follow: Any = None
        self._link: Transport | None = None
        self._came = False
        self.add_on_set_parameters_callback(self._check)
        self.add_post_set_parameters_callback(self._change)

    def value(self, name: str) -> Any:
        """Give a parameter."""
        return self.get_parameter(name).value

    def now(self) -> int:
        """Give the time of the node's clock [ns]."""
        return int(self.get_clock().now().nanoseconds)

    def on_configure(self, _: Any) -> TransitionCallbackReturn:
        """Check what is given, and hear tf."""
        if said := self._load({}):
            self.get_logger().error(said)
            return TransitionCallbackReturn.FAILURE
        self.frames = Frames(self, self.value("tf_stale"))
        return TransitionCallbackReturn.SUCCESS

    def on_activate(self, state: Any) -> TransitionCallbackReturn:
        """Hear odometry and paths, and steer."""
        car, kind, path = self._named
        self._link = Transport(self, lambda: self._tick(came=True))
        sent = Topics(command_type=COMMANDS[self.value("command_type")])
        topics = Topics.of_autoware() if self.value("autoware") else sent
        topics = topics.renamed({}, self.get_name(), self.get_namespace())
        called = ("odometry", "path", "command", "predicted")  # where they are remapped to
        names = {what: self.resolve_topic_name(getattr(topics, what)) for what in called}
        topics = topics.renamed(names)
        given = {name: self.value(name) for name in (*CHANGED, "rate", "timeout", "closed")}
        options = Options(**given, topics=topics)
        make = lambda path: kind(path, car.replace(**self.frames.known))  # noqa: E731
        self.core = Node(self._link, make, options, say=self.get_logger().info)
        self.frames.base, self.frames.axle = self.value("base_frame"), self.value("rear_axle_frame")
        self.frames.known = {}
        self.core.intake.transform = self.frames.transform
        if path is not None:
            self.core.intake.use(path, self.value("path_frame"))
        try:
            from .follow_path import Follow

            self._follow = Follow(self, self.core)
        except ImportError:
            self.get_logger().info("no nav2_msgs: the action follow_path is not offered")
        gc.collect()
        gc.freeze()
        # Periods are those of a steady clock, or of the simulation's.
        simulated = self.value("use_sim_time")
        clock = self.get_clock() if simulated else Clock(clock_type=ClockType.STEADY_TIME)
        self._passed = lambda: int(clock.now().nanoseconds)
        self._pace = Pace(round(options.period * 1e9), self._passed(), self.now())
        self._timer = self.create_timer(options.period, self._tick, clock=clock)
        return super().on_activate(state)

    def on_deactivate(self, state: Any) -> TransitionCallbackReturn:
        """Command to stand, and hear no more."""
        self.stop()
        return super().on_deactivate(state)

    def on_cleanup(self, _: Any) -> TransitionCallbackReturn:
        """Command to stand, and forget tf."""
        self.stop()
        if self.frames is not None:
            self.frames.close()
            self.frames = None
        return TransitionCallbackReturn.SUCCESS

    on_shutdown = on_cleanup

    def stop(self) -> None:
        """Command to stand, and take away what activating has made."""
        if self.core is None or self._link is None:
            return
        if self._follow is not None:
            self._follow.close()
        self.core.finish(self.now())
        self.destroy_timer(self._timer)
        self._link.close()
        self.core = self._link = self._follow = None
        gc.unfreeze()

    def _load(self, new: dict[str, Any]) -> str:
        """Load what the parameters name, some of which are new; says what is wrong with them."""
        given = {name: new.get(name, self.value(name)) for name in PARAMETERS}
        name, file, sent = given["vehicle"], given["path_file"], given["command_type"]
        try:
            car = (Vehicle.load if name.endswith(".toml") else vehicles.get)(name)
            most = math.inf if car.max_speed is None else car.max_speed
            car = car.replace(max_speed=min(given["max_speed"], most))
            if sent not in COMMANDS:
                raise ConfigError.unknown("command_type", sent, COMMANDS)
            path = load_path(file, closed=given["closed"]) if file else None
            self._named = car, controllers.get(given["controller"]).controller, path
        except (PopsteerError, OSError) as error:
            return str(error)
        return ""

    def _tick(self, *, came: bool = False) -> None:
        """Step on the odometry, or by the timer where it stays away, as `spin` does."""
        if self.core is None:
            return
        self._came |= came
        if self._pace.cycle(self.core, self._passed(), self.now(), came=self._came):
            self._came = False
            if self._follow is not None:
                self._follow.check()
        next_one = self._pace.earliest if self._came else self._pace.due
        self._timer.timer_period_ns = max(next_one - self._passed(), 1_000_000)
        self._timer.reset()

    def _check(self, parameters: list[Any]) -> SetParametersResult:
        """Refuse what only a new start can take, and what cannot be."""
        new = {each.name: each.value for each in parameters}
        late = sorted(new.keys() & PARAMETERS.keys() - LIVE) if self.core is not None else []
        said = f"{', '.join(late)} can be changed while the node is inactive" if late else ""
        if self.core is None and self.frames is not None:
            said = self._load(new)
        return SetParametersResult(successful=not said, reason=said)

    def _change(self, _: list[Any]) -> None:
        """Take what the parameters are now."""
        if self.frames is None:
            return
        self.frames.stale = self.value("tf_stale")
        if self.core is None:
            self._load({})
        else:
            self.core.change(**{name: self.value(name) for name in CHANGED})


def main() -> None:
    """Run the node until SIGINT or SIGTERM; it stands until it is activated."""
    # rclpy's own handlers would take the publishers away before the last command.
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    signals, ended = (signal.SIGINT, signal.SIGTERM), threading.Event()
    for each in signals:
        signal.signal(each, lambda *_: ended.set())
    node, executor = Track(), SingleThreadedExecutor()
    executor.add_node(node)
    try:
        while not ended.is_set():
            executor.spin_once(timeout_sec=0.1)
    finally:
        for each in signals:  # `ros2 launch` and the terminal may both send one
            signal.signal(each, signal.SIG_IGN)
        node.stop()
        node.destroy_node()
        rclpy.shutdown()
