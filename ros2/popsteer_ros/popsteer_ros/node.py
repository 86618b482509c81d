"""The lifecycle node: popsteer's own node, with parameters, tf and time of rclpy."""

from __future__ import annotations

import gc
import signal
import threading
import time
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import rclpy
from rcl_interfaces.msg import FloatingPointRange, ParameterDescriptor, SetParametersResult
from rclpy.clock import Clock, ClockType
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.lifecycle import LifecycleNode, TransitionCallbackReturn
from rclpy.signals import SignalHandlerOptions

import popsteer
from popsteer import ConfigError, PopsteerError, controllers
from popsteer.adapters.ros2 import MessageError, Node, Options, Topics, messages
from popsteer.adapters.ros2.pacing import Pace

from .frames import Frames
from .transport import Transport

if TYPE_CHECKING:
    from collections.abc import Callable

COMMANDS = {
    "ackermann": messages.ACKERMANN,
    "control": messages.CONTROL,
    "twist": messages.TWIST,
    "twist_stamped": messages.TWIST_STAMPED,
}
# Name: default, what, range; those of `LIVE` can be changed while it drives.
NUMBERS = {
    "rate": (50.0, "steps a second at most, and where no odometry comes [Hz]", 1.0, 1000.0),
    "stale": (0.3, "odometry older than this is not steered by [s]", 0.01, 1.0),
    "tf_stale": (1.0, "a moving transform older than this is not used [s]", 0.01, 1e6),
    "hold": (0.2, "how long the last command is held before it brakes [s]", 0.0, 10.0),
    "keep_path": (1.0, "how long the last path stays where later ones are refused [s]", 0.0, 1e6),
    "timeout": (10.0, "how long a goal waits for odometry and transforms [s]", 0.0, 1e6),
    "max_speed": (5.0, "go no faster than this [m/s]", 0.01, 1e4),
    "goal_tolerance": (0.25, "a goal is reached this near to the path's end [m]", 0.001, 100.0),
    "progress_distance": (0.5, "progress is to come nearer to the end by this [m]", 0.0, 100.0),
    "progress_time": (10.0, "a goal without progress is aborted after this [s]", 0.1, 1e6),
}
WORDS = {
    "vehicle": ("", "the vehicle: a file *.toml or a name"),
    "controller": ("preview-pop", "the controller"),
    "command_type": ("ackermann", f"what is published: {', '.join(COMMANDS)}"),
    "base_frame": ("", "frame of the vehicle's point; the odometry's child frame if empty"),
    "rear_axle_frame": ("", "frame of the rear axle: its place in base_frame is used"),
    "path_file": ("", "a path as CSV: x, y, speed; or a raceline s; x; y; psi; kappa; vx; ax"),
    "path_frame": ("map", "frame of path_file"),
}
FLAGS = {
    "closed": (False, "whether the last point of a path joins its first"),
    "autoware": (False, "Autoware's topics and messages"),
}
OPTIONS = ("rate", "stale", "hold", "keep_path", "timeout", "closed")
GOALS = ("goal_tolerance", "progress_distance", "progress_time")
LIVE = ("stale", "tf_stale", "hold", "keep_path", *GOALS)
FIXED = {*NUMBERS, *WORDS, *FLAGS} - {*LIVE}


class Track(LifecycleNode):
    """Steers along paths; in its state "active" alone."""

    def __init__(self, **options: Any) -> None:
        super().__init__("popsteer", **options)
        for name, (default, what, *limits) in {**NUMBERS, **WORDS, **FLAGS}.items():
            described = ParameterDescriptor(description=what)
            if limits:
                low, high = limits
                described.floating_point_range = [FloatingPointRange(from_value=low, to_value=high)]
            self.declare_parameter(name, default, described)
        self.core: Node | None = None
        self.frames: Frames | None = None
        self._follow: Any = None
        self._link: Transport | None = None
        self._timer: Any = None
        self._now: Callable[[], int] = time.monotonic_ns
        self._pace = Pace(1, 0, 0)
        self._came = False
        self.add_on_set_parameters_callback(self._check)
        self.add_post_set_parameters_callback(self._change)

    def value(self, name: str) -> Any:
        """Give a parameter."""
        return self.get_parameter(name).value

    def seconds(self) -> float:
        """Give the time of the node's clock [s]."""
        return 1e-9 * self._nanoseconds()

    def _nanoseconds(self) -> int:
        return int(self.get_clock().now().nanoseconds)

    def on_configure(self, _: Any) -> TransitionCallbackReturn:
        """Check what is given, and hear tf."""
        try:
            self._load({})
        except (PopsteerError, OSError) as error:
            self.get_logger().error(str(error))
            return TransitionCallbackReturn.FAILURE
        self.frames = Frames(self)
        return TransitionCallbackReturn.SUCCESS

    def on_activate(self, state: Any) -> TransitionCallbackReturn:
        """Hear odometry and paths, and steer."""
        try:
            car, kind, path = self._load({})
        except (PopsteerError, OSError) as error:
            self.get_logger().error(str(error))
            return TransitionCallbackReturn.FAILURE
        self._link = Transport(self, self._odometry_came)
        plain = Topics.of_autoware() if self.value("autoware") else Topics()
        sent = self.value("command_type")
        names = {"command": "cmd_vel"} if sent.startswith("twist") else {}
        topics = plain.renamed(names, self.get_name(), self.get_namespace())
        if not self.value("autoware"):
            topics = replace(topics, command_type=COMMANDS[sent])
        options = Options(**{name: self.value(name) for name in OPTIONS}, topics=topics)

        def controller(path: popsteer.Path) -> Any:
            return kind(path, self._with_axle(car))

        self.core = Node(self._link, controller, options, say=self.get_logger().info)
        self.frames.base = self.value("base_frame")
        self.core.intake.transform = self.frames.transform
        self._link.release = self.core.release
        if path is not None:
            self.core.intake.use(path, self.value("path_frame"))
        try:
            from .follow_path import Follow

            self._follow = Follow(self)
        except ImportError:
            self.get_logger().info("no nav2_msgs: the action follow_path is not offered")
        gc.collect()
        gc.freeze()
        # Periods are those of a steady clock, or of the simulation's.
        simulated = self.value("use_sim_time")
        self._now = self._nanoseconds if simulated else time.monotonic_ns
        clock = self.get_clock() if simulated else Clock(clock_type=ClockType.STEADY_TIME)
        period = round(options.period * 1e9)
        self._pace = Pace(period, self._now(), self._nanoseconds())
        self._timer = self.create_timer(options.period, self._tick, clock=clock)
        self._change([])
        return super().on_activate(state)

    def on_deactivate(self, state: Any) -> TransitionCallbackReturn:
        """Command to stand, and hear no more."""
        self.stop()
        return super().on_deactivate(state)

    def on_cleanup(self, _: Any) -> TransitionCallbackReturn:
        """Forget tf."""
        if self.frames is not None:
            self.frames.close()
            self.frames = None
        return TransitionCallbackReturn.SUCCESS

    def on_shutdown(self, state: Any) -> TransitionCallbackReturn:
        """Command to stand."""
        self.stop()
        return self.on_cleanup(state)

    def stop(self) -> None:
        """Command to stand, and take away what activating has made."""
        if self.core is None or self._link is None:
            return
        if self._follow is not None:
            self._follow.close()
            self._follow = None
        self.core.finish(self._nanoseconds())
        self.destroy_timer(self._timer)
        self._link.close()
        self.core = self._link = None
        gc.unfreeze()

    def _load(self, new: dict[str, Any]) -> tuple[popsteer.Vehicle, Any, popsteer.Path | None]:
        """Give vehicle, controller and path that the parameters name, some of which are new."""
        names = ("vehicle", "max_speed", "command_type", "controller", "path_file", "closed")
        given, limit, sent, steers, file, closed = (
            new.get(name, self.value(name)) for name in names
        )
        if not given:
            raise ConfigError("vehicle", given, "a file *.toml or a name")
        read = popsteer.Vehicle.load if given.endswith(".toml") else popsteer.vehicles.get
        car = read(given)
        car = car.replace(max_speed=limit if car.max_speed is None else min(limit, car.max_speed))
        if sent not in COMMANDS:
            raise ConfigError.unknown("command_type", sent, COMMANDS)
        path = load_path(file, closed=closed) if file else None
        return car, controllers.get(steers).controller, path

    def _with_axle(self, car: popsteer.Vehicle) -> popsteer.Vehicle:
        """Give the vehicle with the rear axle that tf knows, where it is asked for."""
        axle = self.value("rear_axle_frame")
        try:
            base = self.frames.base or self.core.intake.measured.child_frame
            return car.replace(rear_axle=self.frames.find(base, axle)[0]) if axle else car
        except MessageError as error:
            self.get_logger().warning(f"rear_axle is the vehicle's own: {error}")
            return car

    def _odometry_came(self) -> None:
        self._came = True
        self._tick()

    def _tick(self) -> None:
        """Step on the odometry, or by the timer where it stays away, as `spin` does."""
        core, pace = self.core, self._pace
        if core is None:
            return
        now, came = self._now(), self._came
        if jump := pace.jump(now, self._nanoseconds()):
            core.jumped(jump)
        if now >= (pace.earliest if came else pace.due):
            self._came = False
            core.cycle(self._nanoseconds(), *pace.step(now, came=came))
            if self._follow is not None:
                self._follow.check()
        next_one = pace.earliest if self._came else pace.due
        self._timer.timer_period_ns = max(next_one - self._now(), 1_000_000)
        self._timer.reset()

    def _check(self, parameters: list[Any]) -> SetParametersResult:
        """Refuse what only a new start can take, and what cannot be."""
        new = {each.name: each.value for each in parameters}
        late = sorted(FIXED & {*new}) if self.core is not None else []
        said = f"{', '.join(late)} can be changed while the node is inactive" if late else ""
        if self.core is None and self.frames is not None:
            try:
                self._load(new)
            except (PopsteerError, OSError) as error:
                said = str(error)
        return SetParametersResult(successful=not said, reason=said)

    def _change(self, _: list[Any]) -> None:
        """Take what the parameters are now."""
        if self.core is None or self.frames is None:
            return
        self.frames.stale = self.value("tf_stale")
        now = {name: self.value(name) for name in ("stale", "hold", "keep_path")}
        self.core.options = replace(self.core.options, **now)
        self.core.intake.stale = self.core.options.stale
        if self.core.pilot is not None:
            self.core.pilot.hold = self.core.options.hold


def load_path(file: str, *, closed: bool) -> popsteer.Path:
    """Read a path with speeds: popsteer's CSV, or a raceline whose columns are s; x; y; ...; vx."""
    lines = Path(file).read_text(encoding="utf-8").splitlines()
    text = [line for line in lines if line.strip() and not line.startswith("#")]
    if not text or ";" not in text[0]:
        return popsteer.Path.from_csv(file, closed=closed)
    rows = np.loadtxt(text, delimiter=";", ndmin=2)
    if rows.shape[1] < 6:
        raise popsteer.PathError(f"{file}: a raceline has the columns s; x; y; psi; kappa; vx; ax")
    return popsteer.Path(rows[:, 1:3], speed=rows[:, 5], closed=closed, drop_duplicates=True)


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
    except ExternalShutdownException:
        pass
    finally:
        for each in signals:  # `ros2 launch` and the terminal may both send one
            signal.signal(each, signal.SIG_IGN)
        node.stop()
        node.destroy_node()
        rclpy.try_shutdown()
