"""Nav2's action FollowPath, in place of its controller server: no costmap, no collision check."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from nav2_msgs.action import FollowPath
from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.serialization import serialize_message
from rclpy.task import Future

from popsteer.adapters.ros2 import State

if TYPE_CHECKING:
    from .node import Track

_RESULT = FollowPath.Result
_STANDING = 0.05  # the vehicle has arrived below this [m/s]
_CONTROLLERS = ("", "FollowPath", "popsteer")


class Follow:
    """Drives one goal at a time; a new one takes the place of the old one."""

    def __init__(self, track: Track) -> None:
        self._track = track
        self._goal: Any = None
        self._ended: Any = None
        self._since = self._begun = 0.0
        self._best = math.inf
        self._server = ActionServer(
            track,
            FollowPath,
            "follow_path",
            execute_callback=self._execute,
            goal_callback=self._accept,
            cancel_callback=lambda _: CancelResponse.ACCEPT,
        )

    def close(self) -> None:
        """Offer the action no more."""
        self._end(_RESULT.UNKNOWN, "the node is deactivated")
        self._server.destroy()

    def _accept(self, goal: Any) -> GoalResponse:
        """Refuse what is no goal of this controller, and what comes while it is not active."""
        usable = self._track.core is not None and goal.controller_id in _CONTROLLERS
        return GoalResponse.ACCEPT if usable else GoalResponse.REJECT

    async def _execute(self, goal: Any) -> Any:
        self._end(_RESULT.UNKNOWN, "preempted by another goal")
        core, now = self._track.core, self._track.seconds()
        if core is None or not core.intake.take_course(serialize_message(goal.request.path), now):
            goal.abort()
            said = "" if core is None else core.intake.course_refused
            code = _RESULT.TF_ERROR if "transform" in said else _RESULT.INVALID_PATH
            return _RESULT(error_code=code, error_msg=said)
        self._goal, self._ended = goal, Future()
        self._begun = self._since = now
        self._best = math.inf
        code, said = await self._ended
        return _RESULT(error_code=code, error_msg=said)

    def check(self) -> None:
        """Look after a step whether the goal is reached, cancelled or lost; tell of it."""
        core, track = self._track.core, self._track
        if self._goal is None or core is None:
            return
        now, pilot, measured = track.seconds(), core.pilot, core.intake.measured
        if self._goal.is_cancel_requested:
            self._end(_RESULT.NONE, "cancelled")
        elif pilot is None or pilot.command is None or measured is None:
            if now - self._begun > core.options.timeout:
                self._end(_RESULT.TF_ERROR, core.waits)
        elif pilot.state is not State.DRIVING:  # what it knew of its place may be of another path
            if pilot.state is State.STANDING and now - self._begun > core.options.hold:
                lost = "odometry" in pilot.reason
                self._end(_RESULT.TF_ERROR if lost else _RESULT.NO_VALID_CONTROL, pilot.reason)
        else:
            self._tell(now, pilot.command.distance_to_stop, measured.speed)

    def _tell(self, now: float, remaining: float, speed: float) -> None:
        """Give feedback, and look whether the goal is reached or no more come nearer to."""
        feedback = FollowPath.Feedback(distance_to_goal=float(remaining), speed=float(speed))
        self._goal.publish_feedback(feedback)
        if remaining < self._track.value("goal_tolerance") and abs(speed) < _STANDING:
            return self._end(None, "")
        if remaining < self._best - self._track.value("progress_distance"):
            self._best, self._since = remaining, now
        if now - self._since > self._track.value("progress_time"):
            self._end(_RESULT.FAILED_TO_MAKE_PROGRESS, "no progress along the path")
        return None

    def _end(self, code: int | None, said: str) -> None:
        """End the goal: reached where there is no code, else cancelled or aborted; then stand."""
        if self._goal is None:
            return
        goal, self._goal = self._goal, None
        if code is None:
            goal.succeed()
        elif goal.is_cancel_requested:
            goal.canceled()
        else:
            goal.abort()
        if self._track.core is not None:
            self._track.core.intake.stand()
        self._ended.set_result((code or _RESULT.NONE, said))
