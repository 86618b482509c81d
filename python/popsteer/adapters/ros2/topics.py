"""The topics of the node, and how they are called."""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace
from typing import TYPE_CHECKING

from popsteer.adapters.ros2 import messages
from popsteer.adapters.ros2.names import check_name, expanded
from popsteer.errors import ConfigError

if TYPE_CHECKING:
    from collections.abc import Mapping

COMMANDS = {
    "ackermann": messages.ACKERMANN,
    "control": messages.CONTROL,
    "twist": messages.TWIST,
    "twist_stamped": messages.TWIST_STAMPED,
}
"""The types that a command can have, by the words for them."""
_OPTIONAL = ("speed_limit", "steering", "mode", "operation_mode")


@dataclass(frozen=True)
class Topics:
    """Names of topics, and the types that can be chosen.

    Examples
    --------
    >>> Topics().renamed({"odometry": "/car/odom"}).odometry
    '/car/odom'
    >>> Topics.of_autoware().command
    '/control/trajectory_follower/control_cmd'
    """

    odometry: str = "/odom"
    """In: ``nav_msgs/Odometry``."""
    path: str = "/path"
    """In: ``nav_msgs/Path``, or Autoware's ``Trajectory``."""
    command: str = "/drive"
    """Out: ``ackermann_msgs/AckermannDriveStamped``, or Autoware's ``Control``."""
    predicted: str = "/popsteer/predicted_path"
    """Out: ``nav_msgs/Path``, the trajectory that is intended."""
    diagnostics: str = "/diagnostics"
    """Out: ``diagnostic_msgs/DiagnosticArray``."""
    clock: str = "/clock"
    """In: ``rosgraph_msgs/Clock``, where time is simulated."""
    release: str = "/popsteer/release"
    """In: ``std_msgs/Empty``, which forgets a fault as the service ``~/reset`` does."""
    speed_limit: str = "/speed_limit"
    """In: Nav2's ``SpeedLimit``; none where this is empty."""
    steering: str = ""
    """In: the angle of the wheels as it is measured; none where this is empty, nor of the next."""
    mode: str = ""
    """In: Autoware's ``ControlModeReport``."""
    operation_mode: str = ""
    """In: Autoware's ``OperationModeState``."""
    path_type: str = messages.PATH
    command_type: str = messages.ACKERMANN
    steering_type: str = messages.ACKERMANN

    def __post_init__(self) -> None:
        names = self.names()
        for what, name in names.items():
            check_name(f"topic {what}", name)
            others = [other for other, given in names.items() if given == name]
            if others != [what]:
                raise ConfigError("topic", name, f"given once, not for {' and '.join(others)}")

    @classmethod
    def of_autoware(cls) -> Topics:
        """Give the names and types that Autoware has."""
        return cls(
            odometry="/localization/kinematic_state",
            path="/planning/trajectory",
            command="/control/trajectory_follower/control_cmd",
            steering="/vehicle/status/steering_status",
            mode="/vehicle/status/control_mode",
            operation_mode="/system/operation_mode/state",
            speed_limit="",
            path_type=messages.TRAJECTORY,
            command_type=messages.CONTROL,
            steering_type=messages.STEERING_REPORT,
        )

    def renamed(
        self,
        names: Mapping[str, str],
        node: str = "popsteer",
        namespace: str = "/",
        rules: Mapping[str, str] | None = None,
    ) -> Topics:
        """Give the same with other names.

        Parameters
        ----------
        names : mapping of str to str
            The new names, by field.
        node, namespace : str, optional
            The node's name and namespace, which relative names and those by default are in.
        rules : mapping of str to str, optional
            What to call topics in place of their names, as ROS's remapping rules have it.

        Returns
        -------
        Topics
            The topics.

        Raises
        ------
        ConfigError
            There is no such topic, a name is none that ROS takes, or a topic is given twice.
        """
        known, plain = self.names(), Topics()
        for what in names:
            if what not in (every := dict.fromkeys((*known, *_OPTIONAL))):
                raise ConfigError.unknown("topic", what, every)
        twists = self.command_type in (messages.TWIST, messages.TWIST_STAMPED)
        own = {"odometry": "odom", "path": "path", "command": "cmd_vel" if twists else "drive"}
        own |= {"predicted": "~/predicted_path", "release": "~/release"}
        own["speed_limit"] = "speed_limit"
        relative = {
            what: name for what, name in own.items() if known.get(what) == getattr(plain, what)
        }
        within = node, namespace
        full = {what: expanded(name, *within) for what, name in {**relative, **names}.items()}
        remaps = {expanded(a, *within): expanded(b, *within) for a, b in (rules or {}).items()}
        found = {what: remaps.get(name, name) for what, name in {**known, **full}.items()}
        return replace(self, **found)

    def types(self) -> dict[str, str]:
        """Give the type of each topic, by its name."""
        found = {
            self.odometry: messages.ODOMETRY,
            self.path: self.path_type,
            self.command: self.command_type,
            self.predicted: messages.PATH,
            self.diagnostics: messages.DIAGNOSTICS,
            self.clock: messages.CLOCK,
            self.release: messages.EMPTY,
            self.speed_limit: messages.SPEED_LIMIT,
            self.steering: self.steering_type,
            self.mode: messages.CONTROL_MODE,
            self.operation_mode: messages.OPERATION_MODE,
        }
        found.pop("", None)
        return found

    def names(self) -> dict[str, str]:
        """Give the topics that there are, by field."""
        fields = asdict(self).items()
        return {what: name for what, name in fields if name and not what.endswith("_type")}
