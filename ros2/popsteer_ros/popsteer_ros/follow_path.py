"""Nav2's action FollowPath, in place of its controller server: no costmap, no collision check."""

from __future__ import annotations

import math
from typing import Any, Protocol

from nav2_msgs.action import FollowPath
from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.serialization import serialize_message
from rclpy.task import Future

from popsteer.adapters.ros2 import State

_RESULT = FollowPath.Result
_STANDING = 0.05  # the vehicle has arrived below this [m/s]


class Host(Protocol):
    """The rclpy node that offers the action."""

    def now(self) -> int:
        """Give the time of the node's clock [ns]."""

    def value(self, name: str) -> Any:
        """Give a parameter."""


class Follow:
    """Drives one goal at a time; a new one takes the place of the old one."""

    def __init__(self, host: Host, core: Any) -> None:
        self._host, self._core = host, core
        self._goal: Any = None
        on = {"goal_callback": self._accept, "cancel_callback": lambda _: CancelResponse.ACCEPT}
        self._server = ActionServer(host, FollowPath, "follow_path", self._execute, **on)

    def close(self) -> None:
        """Offer the action no more."""
        self._end(_RESULT.UNKNOWN, "the node is deactivated")
        self._server.destroy()

    def _accept(self, goal: Any) -> GoalResponse:
        """Refuse what is no goal of this controller."""
        usable = goal.controller_id in ("", "FollowPath", "popsteer")
        return GoalResponse.ACCEPT if usable else GoalResponse.REJECT

    async def _execute(self, goal: Any) -> Any:
        # Nav2 sends each replanned path as another goal: it is one drive, whose progress counts on.
        goes_on = self._goal is not None
        self._end(_RESULT.UNKNOWN, "preempted by another goal")
        now, intake = 1e-9 * self._host.now(), self._core.intake
        if not intake.take_course(serialize_message(goal.request.path), now):
            goal.abort()
            said = intake.course_refused
            code = _RESULT.TF_ERROR if "transform" in said else _RESULT.INVALID_PATH
            return _RESULT(error_code=code, error_msg=said)
        self._goal, self._ended = goal, Future()
        self._begun, self._last = now, math.nan
        if not goes_on:
            self._since, self._nearer = now, math.inf
        code, said = await self._ended
        return _RESULT(error_code=code, error_msg=said)

    def check(self) -> None:
        """Look after a step whether the goal is reached, cancelled or lost; tell of it."""
        if self._goal is None:
            return
        core, now = self._core, 1e-9 * self._host.now()
        pilot, measured = core.pilot, core.intake.measured
        if self._goal.is_cancel_requested:
            self._end(_RESULT.NONE, "cancelled")
        elif core.drive is None:
            if now - self._begun > core.options.timeout:
                self._end(_RESULT.TF_ERROR, core.waits)
        elif pilot.state is State.DRIVING:
            self._tell(now, pilot.command.distance_to_stop, measured.speed)
        # In other states what it knew of its place may be of another path.
        elif pilot.state is State.STANDING and now - self._begun > core.options.hold:
            lost = "odometry" in pilot.reason
            self._end(_RESULT.TF_ERROR if lost else _RESULT.NO_VALID_CONTROL, pilot.reason)

    def _tell(self, now: float, remaining: float, speed: float) -> None:
        """Give feedback, and look whether the goal is reached or no more come nearer to."""
        feedback, value = FollowPath.Feedback(), self._host.value
        feedback.distance_to_goal, feedback.speed = remaining, speed
        self._goal.publish_feedback(feedback)
        self._nearer += 0.0 if math.isnan(self._last) else self._last - remaining
        self._last = remaining
        if self._nearer > value("progress_distance"):
            self._nearer, self._since = 0.0, now
        if remaining < value("goal_tolerance") and abs(speed) < _STANDING:
            self._end(None, "")
        elif now - self._since > value("progress_time"):
            self._end(_RESULT.FAILED_TO_MAKE_PROGRESS, "no progress along the path")

    def _end(self, code: int | None, said: str) -> None:
        """End the goal: reached where there is no code, else cancelled or aborted; then stand."""
        if self._goal is None:
            return
        goal, self._goal = self._goal, None
        end = goal.canceled if goal.is_cancel_requested else goal.abort
        (goal.succeed if code is None else end)()
        self._core.intake.stand("the goal has ended")
        self._ended.set_result((code or _RESULT.NONE, said))
