"""Nav2's action FollowPath, in place of its controller server: no costmap, no collision check."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from nav2_msgs.action import FollowPath
from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.task import Future

from popsteer.adapters.ros2 import MessageError
from popsteer.adapters.ros2.paths import inverse, placed, points_of_poses

from .goals import light, poses_of

_KEPT = 10  # for so long a client may ask for a result [s]; each keeps its goal's path


class Follow:
    """Drives one goal at a time; a new one takes the place of the old one.

    It takes goals while it has a `core`, the node that drives. What Nav2's distributions have
    otherwise is told by the fields of its messages: codes, and the feedback's tracking errors.
    `open` is the number of goals whose result is still to come.
    """

    def __init__(self, host: Any) -> None:
        self.core: Any = None
        self._host, self._action = host, FollowPath
        self._goal: Any = None
        self.open = 0
        on = {"goal_callback": self._accept, "cancel_callback": lambda _: CancelResponse.ACCEPT}
        self._server = ActionServer(
            host, light(FollowPath), "follow_path", self._execute, result_timeout=_KEPT, **on
        )

    def stop(self, why: str) -> None:
        """Take no more goals, and end the present one."""
        self._end("UNKNOWN", why)
        self.core = None

    def close(self) -> None:
        """Offer the action no more."""
        self._server.destroy()

    def _accept(self, _: Any) -> GoalResponse:
        return GoalResponse.REJECT if self.core is None else GoalResponse.ACCEPT

    async def _execute(self, goal: Any) -> Any:
        self.open += 1
        code, said = await self._drive(goal)
        self.open -= 1
        return self._result(code, said)

    async def _drive(self, goal: Any) -> tuple[str | None, str]:
        # Nav2 sends each replanned path as another goal: it is one drive, whose progress counts on.
        core, goes_on = self.core, self._goal is not None and not self._goal.is_cancel_requested
        self._end("UNKNOWN", "preempted by another goal", rest=not goes_on)
        if core is None:
            goal.abort()
            return "UNKNOWN", "the node is not active"
        code, said = self._take(goal.request, anew=not goes_on)
        if said or code is None:
            core.rest("the goal has ended")
            (goal.succeed if code is None else goal.abort)()
            return code, said
        self._goal, self._ended = goal, Future()
        self._begun, self._last = 1e-9 * self._host.now(), math.nan
        if not goes_on:
            self._since, self._nearer = self._begun, math.inf
        return tuple(await self._ended)

    def _take(self, request: Any, *, anew: bool) -> tuple[str | None, str]:
        """Take the path of a goal; gives a code and what is wrong, no code where it is there."""
        name, known = request.controller_id, self._host.value("controller_plugins")
        if name not in known and not (name == "" and len(known) == 1):
            return "INVALID_CONTROLLER", f"controller {name[:99]!r} is none of {', '.join(known)}"
        intake, now = self.core.intake, 1e-9 * self._host.now()
        path, code, intake.goals = request.path, "INVALID_PATH", True
        try:
            points = points_of_poses(poses_of(path), path.header.frame_id.lstrip("/"))
            if not len(points.xy):
                return code, "the path has no poses"
            if intake.take_points(points, now, anew=anew):
                return "NONE", ""
            code = "TF_ERROR"
            if (here := intake.here(points.frame, now)) is not None:
                away = np.hypot(*(points.xy - (here.x, here.y)).T).max()
                if (
                    away < self._host.value("goal_tolerance")
                    and not np.ptp(points.xy, axis=0).any()
                ):
                    return None, ""
        except MessageError as error:
            return code, str(error)
        return "INVALID_PATH", intake.course_refused

    def check(self) -> None:
        """Look after a step whether the goal is reached, cancelled or lost; tell of it."""
        if self._goal is None:
            return
        core, now = self.core, 1e-9 * self._host.now()
        if self._goal.is_cancel_requested:
            core.rest("the goal is cancelled")
            if core.stands:
                self._end("NONE", "cancelled")
        elif core.waits:
            if now - self._begun > core.options.timeout:
                self._end("TF_ERROR", core.waits)
        elif core.state == "driving":
            self._tell(now, core.drive, core.intake.measured)
        # In other states what it knew of its place may be of another path.
        elif core.state == "standing" and now - self._begun > core.options.hold:
            lost = "odometry" in core.reason
            self._end("TF_ERROR" if lost else "NO_VALID_CONTROL", core.why)

    def _tell(self, now: float, drive: Any, measured: Any) -> None:
        """Give feedback, and look whether the goal is reached or no more come nearer to."""
        (remaining, segment), value = self._remaining(drive), self._host.value
        feedback = self._action.Feedback()
        told = getattr(feedback, "tracking_feedback", feedback)
        told.distance_to_goal, told.speed = remaining, abs(measured.speed)
        if told is not feedback:  # from Nav2 1.5 on
            self._track(told, drive, measured)
            told.remaining_path_length, told.current_path_index = remaining, segment
        self._goal.publish_feedback(feedback)
        self._nearer += 0.0 if math.isnan(self._last) else self._last - remaining
        self._last = remaining
        if self._nearer > value("progress_distance"):
            self._nearer, self._since = 0.0, now
        if remaining < value("goal_tolerance") and self.core.stands:
            self._end(None, "")
        elif now - self._since > value("progress_time"):
            self._end("FAILED_TO_MAKE_PROGRESS", "no progress along the path")

    def _remaining(self, drive: Any) -> tuple[float, int]:
        """Give how far the goal is, beyond cusps, too [m], and the path's segment."""
        driver = self.core.driver
        path, at = driver.path, driver.state.tracker.place.segment
        remaining = drive.distance_to_stop
        if path.reverse is not None:
            # Where it changes its gear, the place is on the next leg already, the distance not.
            at -= bool(path.reverse[at] != drive.reverse)
            cusps = [k for k in np.flatnonzero(np.diff(path.reverse)) + 1 if k > at]
            remaining += path.length - path.s[cusps[0]] if cusps else 0.0
        return remaining, at

    def _track(self, told: Any, drive: Any, measured: Any) -> None:
        """Give a message of tracking errors what is known, in the frame of the path."""
        intake, pose = self.core.intake, told.robot_pose.pose
        told.header.frame_id = told.robot_pose.header.frame_id = intake.course.frame
        told.header.stamp.sec, told.header.stamp.nanosec = divmod(self._host.now(), 10**9)
        told.robot_pose.header.stamp = told.header.stamp
        told.position_tracking_error = drive.cross_track_error
        told.heading_tracking_error = -drive.heading_error  # positive where it points to the right
        back = inverse(intake.seen_from or (0.0, 0.0, 0.0))
        pose.position.x, pose.position.y, yaw = placed(back, measured[:3])
        pose.orientation.z, pose.orientation.w = math.sin(0.5 * yaw), math.cos(0.5 * yaw)

    def _end(self, code: str | None, said: str, *, rest: bool = True) -> None:
        """End the goal: reached where there is no code, else cancelled or aborted; then stand."""
        if self._goal is None:
            return
        goal, self._goal = self._goal, None
        end = goal.canceled if goal.is_cancel_requested else goal.abort
        (goal.succeed if code is None else end)()
        if rest:
            self.core.rest("the goal has ended")
        if rest and code not in (None, "NONE"):  # of a planner's next path nothing is to be told
            self._host.get_logger().error(f"goal ended: {said}")
        self._ended.set_result((code, said))

    def _result(self, code: str | None, said: str) -> Any:
        """Make a result, of the fields that this distribution has."""
        found = self._action.Result()
        if hasattr(found, "error_code"):
            named = self._action.Result if hasattr(found, "NONE") else self._action.Goal  # Iron's
            found.error_code = getattr(named, code or "NONE")
        if hasattr(found, "error_msg"):
            found.error_msg = said
        return found
