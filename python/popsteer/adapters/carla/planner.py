"""A local planner for CARLA's agents that drives with a controller of popsteer."""

from __future__ import annotations

import warnings
from typing import TYPE_CHECKING, Any

from popsteer import Command, InputError, Path, PreviewPop, SpeedPid, Status, Vehicle
from popsteer.adapters.carla import conversions
from popsteer.adapters.carla.route import RoadOption, Route
from popsteer.adapters.carla.vehicle import steering_of, vehicle_of
from popsteer.errors import PopsteerError
from popsteer.sim.closed_loop import KEEPING

if TYPE_CHECKING:
    from collections import deque
    from collections.abc import Callable, Iterable, Mapping

    import carla

    from popsteer.adapters.carla.conversions import Steering
    from popsteer.controllers import Controller

_ROAMING = 100  # waypoints kept ahead where there is no plan, as CARLA's planner keeps
_ARRIVED = 1.0  # the last waypoint counts as reached from here on [m], as there
_GAINS = ("lateral_control_dict", "longitudinal_control_dict")


class LocalPlanner:
    """A local planner for CARLA's agents, with a controller of popsteer in it.

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
    controller : callable, optional
        Makes the controller from path and vehicle: a class such as `Pop` or `Stanley`, or
        ``functools.partial(PreviewPop, params=...)``. `PreviewPop` by default.
    longitudinal : SpeedPid, optional
        What works the pedals; by default with kp = 1 s/m and ki = 0.5 /m.

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
    A pose that is refused is held, as `PreviewPop.step_or_hold` does. For a status that is a fault
    it brakes to a standstill, and stays there until `set_global_plan`. Past the end of the plan it
    brakes fully.
    """

    def __init__(
        self,
        vehicle: carla.Vehicle,
        opt_dict: Mapping[str, Any] | None = None,
        map_inst: carla.Map | None = None,
        *,
        car: Vehicle | None = None,
        steering: Steering | None = None,
        controller: Callable[[Path, Vehicle], Controller] = PreviewPop,
        longitudinal: SpeedPid | None = None,
    ) -> None:
        conversions.client_library()  # names the extra where it is missing
        options = dict(opt_dict or {})
        if unused := [name for name in _GAINS if name in options]:
            warnings.warn(
                f"popsteer steers without CARLA's PID loops: {', '.join(unused)} not used",
                stacklevel=2,
            )
        self._actor: carla.Vehicle | None = vehicle
        self._world = vehicle.get_world()
        self._map = self._world.get_map() if map_inst is None else map_inst
        self._steering = steering_of(vehicle) if steering is None else steering
        car = vehicle_of(vehicle) if car is None else car
        share = float(options.get("max_steering", 1.0))
        allowed = min(car.max_steer, abs(self._steering.angle(share)))
        self._car = car.replace(max_steer=allowed)
        self._make = controller
        self._pedals = SpeedPid(KEEPING) if longitudinal is None else longitudinal
        self._controller: Controller | None = None
        self._fault = Status.OK
        self._command: Command | None = None
        self._control: tuple[float, float] = (0.0, 1.0)
        self._target_speed = float(options.get("target_speed", 20.0))
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
    def controller(self) -> Controller | None:
        """The controller; None before there is a path."""
        return self._controller

    @property
    def command(self) -> Command | None:
        """The last command of the controller (errors, status, target); None before the first."""
        return self._command

    @property
    def fault(self) -> Status:
        """Why it has stopped: the status that was a fault; ``Status.OK`` if none was."""
        return self._fault

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
        self._fault = Status.OK
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
        speed, steer = self._advance(debug=debug)
        throttle, brake = self._control
        return conversions.vehicle_control(
            steer,
            min(throttle, self._max_throttle),
            brake if self._stops() else min(brake, self._max_brake),
            steering=self._steering,
            speed=speed,
        )

    def run_ackermann_step(self, debug: bool = False) -> carla.VehicleAckermannControl:  # noqa: FBT001, FBT002
        """Take one control step that leaves the pedals to CARLA, as `run_step` else.

        The answer is for ``actor.apply_ackermann_control``; its speed is 0 at the end of the plan.
        """
        _, steer = self._advance(debug=debug)
        wanted = conversions.speed_from_kmh(self._target_speed)
        return conversions.ackermann_control(steer, 0.0 if self._stops() else wanted)

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
        path = self._route.path()
        if path is None:
            return
        if self._controller is None:
            self._controller = self._make(path, self._car)
        else:
            self._controller.set_path(path)

    def _stops(self) -> bool:
        if self._command is not None and self._command.status.level == "fault":
            self._fault = self._command.status
        return bool(self._fault) or self.done() or self._controller is None

    def _passed(self) -> float:
        """Say how much time has passed in the simulator since the last step [s]."""
        now = float(self._world.get_snapshot().timestamp.elapsed_seconds)
        before, self._time = self._time, now
        # A simulator that was started anew counts from 0.
        return self._dt if before is None or now < before else now - before

    def _advance(self, *, debug: bool) -> tuple[float, float]:
        """Take a step of everything; the speed [m/s] and the angle of the wheels [rad]."""
        if self._follows_limits:
            self._target_speed = self._driven.get_speed_limit()
        if self._roams and len(self._route.ahead) < _ROAMING:
            self._route.grow(_ROAMING, self._spacing)
            self._renew_path()
        transform = self._driven.get_transform()
        speed = conversions.speed_of(self._driven.get_velocity(), transform)
        dt = self._passed()
        if self._controller is None:
            self._control = 0.0, 1.0
        elif dt > 0.0 or self._command is None:
            self._step(self._controller, conversions.pose_of(transform), speed, dt)
        if debug:
            carla = conversions.client_library()
            place = self.target_waypoint.transform.location + carla.Location(z=1.0)
            self._world.debug.draw_point(place, life_time=1.0)
        return speed, self._command.steer if self._command is not None else 0.0

    def _step(
        self, controller: Controller, pose: tuple[float, float, float], speed: float, dt: float
    ) -> None:
        command = self._command = controller.step_or_hold(*pose, speed, dt)
        held = Status.INPUT_HELD in command.status or Status.INPUT_LOST in command.status
        if not held:
            # The rear axle's place along the path, and the actor's before it.
            place = controller.path.length - command.distance_to_stop - self._car.rear_axle
            self._route.pass_until(place, self._near + self._near_time * abs(speed), _ARRIVED)
            if self._route.ahead:
                self.target_waypoint, self.target_road_option = self._route.ahead[0]
        if self._stops():
            self._control = 0.0, 1.0
        elif not held:
            try:
                wanted = conversions.speed_from_kmh(self._target_speed)
                self._control = self._pedals.step(speed, wanted, dt)
            except InputError:  # a target speed that is no number: coast
                self._control = 0.0, 0.0
