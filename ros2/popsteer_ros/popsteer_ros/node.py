"""The lifecycle node: popsteer's own node, with parameters, tf and time of rclpy."""

from __future__ import annotations

import gc
import time
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import rclpy
from rcl_interfaces.msg import FloatingPointRange, ParameterDescriptor, SetParametersResult
from rclpy.executors import ExternalShutdownException
from rclpy.lifecycle import LifecycleNode, TransitionCallbackReturn

import popsteer
from popsteer import PopsteerError, controllers
from popsteer.adapters.ros2 import MessageError, Node, Options, Topics, messages

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
    "hold": (0.2, "how long the last command is held before it brakes [s]", 0.0, 10.0),
    "keep_path": (1.0, "how long the last path stays where later ones are refused [s]", 0.0, 1e6),
    "timeout": (10.0, "how long a goal waits for odometry and transforms [s]", 0.0, 1e6),
    "max_speed": (5.0, "go no faster than this [m/s]", 0.01, 1e4),
    "goal_tolerance": (0.25, "a goal is reached this near to the path's end [m]", 0.001, 100.0),
    "progress_distance": (0.5, "progress is to come nearer to the end by this [m]", 0.0, 100.0),
    "progress_time": (10.0, "a goal without progress is aborted after this [s]", 0.1, 1e6),
}
LIVE = ("stale", "hold", "keep_path", "goal_tolerance", "progress_distance", "progress_time")
WORDS = {
    "vehicle": ("", "the vehicle: a file *.toml or a name"),
    "controller": ("preview-pop", "the controller"),
    "command_type": ("ackermann", f"what is published: {', '.join(COMMANDS)}"),
    "base_frame": ("", "frame of the vehicle's point; the odometry's child frame if empty"),
    "rear_axle_frame": (
        "",
        "frame of the rear axle: its place in base_frame is used if tf knows it",
    ),
    "path_file": ("", "a path as CSV: x, y, speed; or a raceline s; x; y; psi; kappa; vx; ax"),
    "path_frame": ("map", "frame of path_file"),
}
FLAGS = {
    "closed": "whether the last point of a path joins its first",
    "autoware": "Autoware's topics and messages",
}


class Track(LifecycleNode):
    """Steers along paths; in its state "active" alone."""

    def __init__(self, **options: Any) -> None:
        super().__init__("popsteer", **options)
        for name, (number, what, low, high) in NUMBERS.items():
            limits = [FloatingPointRange(from_value=low, to_value=high)]
            described = ParameterDescriptor(description=what, floating_point_range=limits)
            self.declare_parameter(name, number, described)
        for name, (word, what) in WORDS.items():
            self.declare_parameter(name, word, ParameterDescriptor(description=what))
        for name, what in FLAGS.items():
            self.declare_parameter(
                name, value=False, descriptor=ParameterDescriptor(description=what)
            )
        self.core: Node | None = None
        self.frames: Frames | None = None
        self._follow: Any = None
        self._link: Transport | None = None
        self._timer: Any = None
        self._now: Callable[[], int] = time.monotonic_ns
        self._before = self._base = 0
        self._came = False
        self.add_on_set_parameters_callback(self._change)

    def value(self, name: str) -> Any:
        """Give a parameter."""
        return self.get_parameter(name).value

    def seconds(self) -> float:
        """Give the time of the node's clock [s]."""
        return 1e-9 * self._nanoseconds()

    def _nanoseconds(self) -> int:
        return int(self.get_clock().now().nanoseconds)

    def on_configure(self, _: Any) -> TransitionCallbackReturn:
        """Check what is given, hear tf, and load the vehicle."""
        try:
            self._load()
        except (PopsteerError, OSError, KeyError) as error:
            self.get_logger().error(str(error))
            return TransitionCallbackReturn.FAILURE
        self.frames = Frames(self, self.value("base_frame"))
        return TransitionCallbackReturn.SUCCESS

    def on_activate(self, state: Any) -> TransitionCallbackReturn:
        """Hear odometry and paths, and steer."""
        if self.frames is None:
            return TransitionCallbackReturn.FAILURE
        self._link = Transport(self, self._odometry_came)
        plain = Topics.of_autoware() if self.value("autoware") else Topics()
        kind = self.value("command_type")
        names = {"command": "cmd_vel"} if kind.startswith("twist") else {}
        topics = plain.renamed(names, self.get_name(), self.get_namespace())
        if not self.value("autoware"):
            topics = replace(topics, command_type=COMMANDS[kind])
        numbers = {
            name: self.value(name) for name in ("rate", "stale", "hold", "keep_path", "timeout")
        }
        options = Options(**numbers, closed=self.value("closed"), topics=topics)
        self.core = Node(self._link, self._controller, options, say=self.get_logger().info)
        self.core.intake.transform = self.frames.transform
        self._link.release = self.core.release
        if self.value("path_file"):
            path = load_path(self.value("path_file"), closed=self.value("closed"))
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
        self._before = self._base = self._now()
        self._timer = self.create_timer(0.25 / options.rate, self._tick)
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

    def _load(self) -> tuple[popsteer.Vehicle, Any]:
        given = self.value("vehicle")
        read = popsteer.Vehicle.load if given.endswith(".toml") else popsteer.vehicles.get
        car = read(given)
        limit = self.value("max_speed")
        car = car.replace(max_speed=limit if car.max_speed is None else min(limit, car.max_speed))
        if self.value("command_type") not in COMMANDS:
            raise popsteer.ConfigError.unknown("command_type", self.value("command_type"), COMMANDS)
        return car, controllers.get(self.value("controller")).controller

    def _controller(self, path: popsteer.Path) -> Any:
        car, kind = self._load()
        axle, base = self.value("rear_axle_frame"), self.value("base_frame") or "base_link"
        if axle and self.frames is not None:
            try:
                car = car.replace(rear_axle=self.frames.find(base, axle)[0])
            except MessageError as error:
                self.get_logger().warning(f"rear_axle is the vehicle's own: {error}")
        return kind(path, car)

    def _odometry_came(self) -> None:
        self._came = True
        self._tick()

    def _tick(self) -> None:
        """Step on the odometry, or by the timer where it stays away, as `spin` does."""
        core = self.core
        if core is None:
            return
        period = round(1e9 / core.options.rate)
        now = self._now()
        if now < self._before:  # a simulation that begins anew
            core.jumped(1e-9 * (now - self._before))
            self._before = self._base = now
        passed = now - self._base
        if passed < 0.75 * period or not (self._came or passed >= 1.5 * period):
            return
        missed = max(passed - period * 3 // 2, 0) // period
        core.cycle(self._nanoseconds(), 1e-9 * (now - self._before), missed)
        self._before = self._base = now
        self._came = False
        if self._follow is not None:
            self._follow.check()

    def _change(self, parameters: list[Any]) -> SetParametersResult:
        """Take new values while it drives; refuse those that only a new start can take."""
        for each in parameters:
            if self.core is not None and each.name not in (*LIVE, "use_sim_time"):
                if each.name in (*NUMBERS, *WORDS, *FLAGS):
                    said = f"{each.name} can be changed while the node is inactive"
                    return SetParametersResult(successful=False, reason=said)
            elif self.core is not None and each.name in ("stale", "hold", "keep_path"):
                self.core.options = replace(self.core.options, **{each.name: each.value})
                self.core.intake.stale = self.core.options.stale
                if self.core.pilot is not None:
                    self.core.pilot.hold = self.core.options.hold
        return SetParametersResult(successful=True)


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
    """Run the node; it stands until it is activated."""
    rclpy.init()
    node = Track()
    try:
        rclpy.spin(node)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        node.stop()
        node.destroy_node()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
