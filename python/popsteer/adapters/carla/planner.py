"""A local planner for CARLA's agents that drives by `popsteer.Driver`."""

from __future__ import annotations

import math
import warnings
from collections import deque
from difflib import get_close_matches
from typing import TYPE_CHECKING, Any

from popsteer import Driver
from popsteer.adapters.carla import conversions
from popsteer.adapters.carla.route import RoadOption, Route
from popsteer.adapters.carla.vehicle import steering_of, vehicle_of
from popsteer.errors import PopsteerError
from popsteer.sim import PedalMap

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping

    import carla

    from popsteer import Drive, Path, Vehicle
    from popsteer.adapters.carla.conversions import Steering

_ROAMING = 100  # waypoints kept ahead where there is no plan, as CARLA's planner keeps
_ARRIVED = 1.0  # the last waypoint counts as reached from here on [m], as there
_ASIDE = 1.0  # a longer time without a step is one in which somebody else has driven [s]
_SAME = 1e-6  # shares of the lock that are one, of single precision
_GAINS = ("lateral_control_dict", "longitudinal_control_dict")
_OPTIONS = {
    *("target_speed", "follow_speed_limits", "sampling_radius", "max_throttle", "max_brake"),
    *("max_steering", "base_min_distance", "distance_ratio", "dt", "offset"),
}


class LocalPlanner:
    """A local planner for CARLA's agents, with a `popsteer.Driver` in it.

    It takes the same arguments as CARLA's, in the same order, and has the same methods::

        agent = BasicAgent(actor)
        agent._local_planner = LocalPlanner(actor)

    It follows the lane from where the actor is, at forks along any branch, until it is given a
    plan. Each step reads the actor's pose and speed and the time that has passed in the simulator.

    Parameters
    ----------
    vehicle : carla.Vehicle
        The actor that is driven; the world has ticked since it was spawned.
    opt_dict : mapping, optional
        Options of CARLA's planner: ``target_speed`` [km/h] (20 by default), ``sampling_radius``
        [m] (2), ``max_throttle``, ``max_brake``, ``max_steering`` (1 each), ``offset`` [m to the
        right] (0), ``base_min_distance`` [m] (3), ``distance_ratio`` [s] (0.5),
        ``follow_speed_limits`` and ``dt`` [s] (0.05), the time of the first step. The gains of its
        PID loops do not apply, which a warning says; others are the agent's.
    map_inst : carla.Map, optional
        The map; by default the world's, which takes the server long to send.
    car : Vehicle, optional
        What popsteer is told of it; by default `vehicle_of` the actor.
    steering : Steering, optional
        What a share of full lock is; by default `steering_of` the actor.
    driver : callable, optional
        Makes the driver from path and vehicle, as ``functools.partial(popsteer.Driver,
        controller=popsteer.StanleyParams())``. `popsteer.Driver` by default.
    pedals : callable, optional
        Gives throttle and brake for an acceleration [m/s²] and a speed [m/s], both in the direction
        of driving: a `popsteer.sim.PedalMap`, by default that of the car that was identified in
        CARLA. What it is wrong by, the driver learns in a second.

    Attributes
    ----------
    target_waypoint : carla.Waypoint
        The next waypoint of the plan.
    target_road_option : RoadOption
        How the route leads there.

    Raises
    ------
    PopsteerError
        The extra ``carla`` is not installed, or the actor does not say where its wheels are.
    ConfigError
        The vehicle or the lock is out of its range.

    Notes
    -----
    It drives at ``target_speed``, slower in bends by the vehicle's limits, and stops with the
    actor's point, or the `stop_point` of `car`, at the end of the plan; in comfort at a target
    speed of 0. A fault stops it as it does a `Driver`, until `set_global_plan`. An agent may brake
    and steer in its place: it knows of the angle by the actor's control, and begins anew after a
    time of more than 1 s in which no step was asked for.
    """

    def __init__(
        self,
        vehicle: carla.Vehicle,
        opt_dict: Mapping[str, Any] | None = None,
        map_inst: carla.Map | None = None,
        *,
        car: Vehicle | None = None,
        steering: Steering | None = None,
        driver: Callable[[Path, Vehicle], Driver] = Driver,
        pedals: Callable[[float, float], tuple[float, float]] | None = None,
    ) -> None:
        conversions.client_library()  # names the extra where it is missing
        options = dict(opt_dict or {})
        if unused := [name for name in _GAINS if name in options]:
            warnings.warn(
                f"popsteer steers without CARLA's PID loops: {', '.join(unused)} not used",
                stacklevel=2,
            )
        for name in options.keys() - _OPTIONS:
            # Others are the agent's, whose names are not known here.
            if near := get_close_matches(name, _OPTIONS, 1, 0.8):
                said = f"option {name!r} is not used: did you mean {near[0]!r}?"
                warnings.warn(said, stacklevel=2)
        self._actor: carla.Vehicle | None = vehicle
        self._world = vehicle.get_world()
        self._map = self._world.get_map() if map_inst is None else map_inst
        self._steering = steering_of(vehicle) if steering is None else steering
        car = vehicle_of(vehicle) if car is None else car
        share = float(options.get("max_steering", 1.0))
        allowed = min(car.max_steer, abs(self._steering.angle(share)))
        self._car = car.replace(max_steer=allowed)
        self._make = driver
        self._pedals = PedalMap.of("carla-identified") if pedals is None else pedals
        self._driver: Driver | None = None
        self._drive: Drive | None = None
        # The shares of the lock of the last answers: without a common clock an actor may have an
        # older one than the last.
        self._sent: deque[float] = deque(maxlen=3)
        self._target_speed = float(options.get("target_speed", 20.0))
        self._planned = self._target_speed
        self._follows_limits = bool(options.get("follow_speed_limits", False))
        self._spacing = float(options.get("sampling_radius", 2.0))
        self._max_throttle = float(options.get("max_throttle", 1.0))
        self._max_brake = float(options.get("max_brake", 1.0))
        self._near = float(options.get("base_min_distance", 3.0))
        self._near_time = float(options.get("distance_ratio", 0.5))
        self._roams = True
        self._dt = float(options.get("dt", 0.05))
        self._time: float | None = None
        here = self._map.get_waypoint(vehicle.get_location())
        self._route = Route(here, float(options.get("offset", 0.0)))
        self.target_waypoint: carla.Waypoint = here
        self.target_road_option: int = RoadOption.LANEFOLLOW

    @property
    def driver(self) -> Driver | None:
        """The driver; None before there is a path."""
        return self._driver

    @property
    def drive(self) -> Drive | None:
        """The driver's last answer (errors, status, target); None before the first."""
        return self._drive

    @property
    def fault(self) -> str | None:
        """What the driver stops for; None if nothing is wrong."""
        return None if self._driver is None else self._driver.fault

    @property
    def car(self) -> Vehicle:
        """What popsteer is told of the actor, `max_steer` as small as ``max_steering`` has it."""
        return self._car

    def reset_vehicle(self) -> None:
        """Let go of the actor, as CARLA's planner does; steps are refused from then on."""
        self._actor = None

    def set_speed(self, speed: float) -> None:
        """Set the speed to go at [km/h]; where speed limits are followed, these count."""
        self._target_speed = speed

    def follow_speed_limits(self, value: bool = True) -> None:  # noqa: FBT001, FBT002 - as CARLA's
        """Go at the actor's speed limit, or no longer."""
        self._follows_limits = value

    def set_offset(self, offset: float) -> None:
        """Drive beside the waypoints, so far to the right [m]; to the left where it is negative."""
        self._route.offset = offset
        self._renew_path()

    def set_global_plan(
        self,
        current_plan: Iterable[tuple[carla.Waypoint, int]],
        stop_waypoint_creation: bool = True,  # noqa: FBT001, FBT002 - as CARLA's
        clean_queue: bool = True,  # noqa: FBT001, FBT002 - as CARLA's
    ) -> None:
        """Follow a plan.

        Parameters
        ----------
        current_plan : iterable of tuple
            Pairs of a ``carla.Waypoint`` and a road option, as ``GlobalRoutePlanner`` gives them.
        stop_waypoint_creation : bool, default True
            Whether to end where the plan ends, instead of following the lane on from there.
        clean_queue : bool, default True
            Whether the plan takes the place of what there is, instead of being added to it.
        """
        if clean_queue:
            self._route.replace(current_plan, self._driven.get_location())
        else:
            self._route.add(current_plan)
        self._roams = not stop_waypoint_creation
        if self.fault is not None:
            self._driver = None  # nothing counts of what it has stopped for
        self._renew_path()

    def run_step(self, debug: bool = False) -> carla.VehicleControl:  # noqa: FBT001, FBT002 - as CARLA's
        """Take one control step.

        Parameters
        ----------
        debug : bool, default False
            Whether the simulator shows the next waypoint.

        Returns
        -------
        carla.VehicleControl
            For ``actor.apply_control``. In the frame of the last step it is that step's.
        """
        drive, speed = self._advance(debug=debug)
        if drive is None:
            return conversions.vehicle_control(0.0, 0.0, 1.0, steering=self._steering)
        sign = -1.0 if drive.reverse else 1.0
        if not math.isfinite(speed):
            speed = sign * drive.speed
        throttle, brake = self._pedals(drive.acceleration, sign * speed)
        control = conversions.vehicle_control(
            drive.steer,
            min(throttle, self._max_throttle),
            1.0 if drive.hold else brake if drive.fault else min(brake, self._max_brake),
            steering=self._steering,
            speed=speed,
            reverse=drive.reverse,
        )
        self._sent.append(control.steer)
        return control

    def run_ackermann_step(self, debug: bool = False) -> carla.VehicleAckermannControl:  # noqa: FBT001, FBT002
        """Take one control step that leaves the pedals to CARLA, as `run_step` else.

        The answer is for ``actor.apply_ackermann_control``, with the driver's speed.
        """
        drive, _ = self._advance(debug=debug)
        if drive is None:
            return conversions.ackermann_control(0.0, 0.0)
        return conversions.ackermann_control(
            drive.steer, -drive.speed if drive.reverse else drive.speed
        )

    def done(self) -> bool:
        """Say whether the plan is driven to its end: no waypoint remains."""
        return not self._route.ahead

    def get_plan(self) -> deque[tuple[carla.Waypoint, int]]:
        """Give the rest of the plan: pairs of waypoint and road option, the next one first."""
        return self._route.ahead

    def get_incoming_waypoint_and_direction(
        self, steps: int = 3
    ) -> tuple[carla.Waypoint | None, int]:
        """Give a waypoint further ahead.

        Parameters
        ----------
        steps : int, default 3
            How many waypoints after the next one; the last one where there are fewer.

        Returns
        -------
        tuple
            Waypoint and road option; ``(None, RoadOption.VOID)`` at the end of the plan.
        """
        ahead = self._route.ahead
        if not ahead:
            return None, RoadOption.VOID
        return ahead[steps] if len(ahead) > steps else ahead[-1]

    @property
    def _driven(self) -> carla.Vehicle:
        if self._actor is None:
            raise PopsteerError("the planner has no vehicle after reset_vehicle: make another one")
        return self._actor

    def _renew_path(self) -> None:
        self._planned = wanted = self._target_speed
        drives = wanted > 0.0  # nan does not
        path = self._route.path(conversions.speed_from_kmh(wanted) if drives else None)
        if path is None:
            return
        if self._driver is None:
            self._driver = self._make(path, self._car)
            if self._drive is not None:
                self._begin(self._driver)
        else:
            self._driver.set_path(path)
        (self._driver.go if drives else self._driver.hold)()

    def _passed(self) -> float:
        """Say how much time has passed in the simulator since the last step [s]."""
        now = float(self._world.get_snapshot().timestamp.elapsed_seconds)
        before, self._time = self._time, now
        # A simulator that was started anew counts from 0.
        return self._dt if before is None or now < before else now - before

    def _advance(self, *, debug: bool) -> tuple[Drive | None, float]:
        """Take a step of everything; the driver's answer, and the speed [m/s]."""
        if self._follows_limits:
            self._target_speed = self._driven.get_speed_limit()
        grows = self._roams and len(self._route.ahead) < _ROAMING
        if grows:
            self._route.grow(_ROAMING, self._spacing)
        if grows or self._target_speed != self._planned:
            self._renew_path()
        (pose, speed), dt = self._measured(), self._passed()
        if (driver := self._driver) is not None:
            if dt > _ASIDE and driver.fault is None:
                self._begin(driver)
            drive = driver.step(*pose, speed, dt, applied_steer=self._applied(speed))
            self._drive = drive
            if drive.fault is None and math.isfinite(speed):
                self._pass_waypoints(driver, speed)
        if debug:
            carla = conversions.client_library()
            place = self.target_waypoint.transform.location + carla.Location(z=1.0)
            self._world.debug.draw_point(place, life_time=1.0)
        return self._drive, speed

    def _begin(self, driver: Driver) -> None:
        """Let a driver begin anew, with the wheels where they are."""
        at, most = self._angle(self._measured()[1]), self._car.max_steer
        driver.reset(steer=max(-most, min(at, most)))

    def _measured(self) -> tuple[tuple[float, float, float], float]:
        """Give the actor's pose, and its speed along the heading [m/s].

        Nothing of a pose is believed of which a number is not finite, nor that speed.
        """
        transform = self._driven.get_transform()
        pose = conversions.pose_of(transform)
        if not all(map(math.isfinite, pose)):
            return (math.nan, math.nan, math.nan), math.nan
        return pose, conversions.speed_of(self._driven.get_velocity(), transform)

    def _angle(self, speed: float) -> float:
        """Give the angle that the actor was told last [rad]."""
        return self._steering.angle(self._driven.get_control().steer, speed)

    def _applied(self, speed: float) -> float | None:
        """Give the angle that the actor was told last [rad], where none of the last answers did."""
        share = self._driven.get_control().steer
        own = any(abs(share - sent) < _SAME for sent in self._sent)
        return None if own or not self._sent else self._angle(speed)

    def _pass_waypoints(self, driver: Driver, speed: float) -> None:
        """Let go the waypoints that are driven, by where the actor's point is on the path."""
        path, place = driver.path, driver.state.tracker.place
        if place is None or place.lost:
            return
        at, (x, y) = place.segment, place.point
        (begin_x, end_x), (begin_y, end_y) = path.x[at : at + 2], path.y[at : at + 2]
        dx, dy = end_x - begin_x, end_y - begin_y
        along = ((x - begin_x) * dx + (y - begin_y) * dy) / math.hypot(dx, dy)
        axle = float(path.s[at]) + along  # also before the path's begin
        reach = self._near + self._near_time * abs(speed)
        self._route.pass_until(axle - self._car.rear_axle, reach, _ARRIVED)
        if self._route.ahead:
            self.target_waypoint, self.target_road_option = self._route.ahead[0]
