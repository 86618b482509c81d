"""The topics of the node, and how they are called."""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace
from typing import TYPE_CHECKING

from popsteer.adapters.ros2.messages import (
    ACKERMANN,
    CLOCK,
    CONTROL,
    DIAGNOSTICS,
    ODOMETRY,
    PATH,
    TRAJECTORY,
)
from popsteer.errors import ConfigError

if TYPE_CHECKING:
    from collections.abc import Mapping

__all__ = ["Topics"]


@dataclass(frozen=True)
class Topics:
    """Names of topics, and the two types that can be chosen.

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
    path_type: str = PATH
    command_type: str = ACKERMANN

    @classmethod
    def of_autoware(cls) -> Topics:
        """Give the names and types that Autoware has.

        Returns
        -------
        Topics
            The topics.
        """
        return cls(
            odometry="/localization/kinematic_state",
            path="/planning/trajectory",
            command="/control/trajectory_follower/control_cmd",
            path_type=TRAJECTORY,
            command_type=CONTROL,
        )

    def renamed(self, names: Mapping[str, str]) -> Topics:
        """Give the same with other names.

        Parameters
        ----------
        names : mapping of str to str
            The new names, by field.

        Returns
        -------
        Topics
            The topics.

        Raises
        ------
        ConfigError
            There is no such topic, or a name does not begin with a slash.
        """
        known = [name for name in asdict(self) if not name.endswith("_type")]
        for what, name in names.items():
            if what not in known:
                raise ConfigError.unknown("topic", what, known)
            if not name.startswith("/") or not name.strip("/"):
                raise ConfigError(f"topic {what}", name, "a name that begins with /")
        return replace(self, **names)

    def types(self) -> dict[str, str]:
        """Give the type of each topic.

        Returns
        -------
        dict of str to str
            Types by name of the topic.
        """
        return {
            self.odometry: ODOMETRY,
            self.path: self.path_type,
            self.command: self.command_type,
            self.predicted: PATH,
            self.diagnostics: DIAGNOSTICS,
            self.clock: CLOCK,
        }
