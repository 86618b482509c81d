"""The vehicle models of CommonRoad, with the limits that they have.

M. Althoff, G. Würsching, *CommonRoad: Vehicle Models*, 2020; the package is
``commonroad-vehicle-models``. A model gives the derivative of its state under two inputs, the rate
of the front wheels' angle and the acceleration; here the classical Runge-Kutta method of fourth
order integrates it, in steps that shrink with the speed, because the dynamics of a tyre's slip get
faster the slower it rolls.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

from vehiclemodels.init_mb import init_mb
from vehiclemodels.init_st import init_st
from vehiclemodels.init_std import init_std
from vehiclemodels.vehicle_dynamics_mb import vehicle_dynamics_mb
from vehiclemodels.vehicle_dynamics_st import vehicle_dynamics_st
from vehiclemodels.vehicle_dynamics_std import vehicle_dynamics_std
from vehiclemodels.vehicle_parameters import setup_vehicle_parameters

from popsteer.errors import ConfigError, InputError, PlantLimit
from popsteer.plants.pedals import PedalParams
from popsteer.plants.protocol import PlantState, Varied, follow, published
from popsteer.ranges import check_known

if TYPE_CHECKING:
    from collections.abc import Callable

_GRAVITY = 9.81
# The models change to kinematics at this speed, and the slip no longer sets the pace.
_KINEMATIC_SPEED = 0.1


class _Model(NamedTuple):
    derivative: Callable[..., list[float]]
    initial: Callable[..., list[float]]
    least_speed: float
    """Below this speed the model is not valid [m/s]."""
    step_per_speed: float
    """Longest step for each metre per second [s^2/m]: a fifth of what would be unstable."""


_MODELS = {
    "st": _Model(vehicle_dynamics_st, lambda core, _: init_st(core), 0.0, 2e-3),
    "std": _Model(vehicle_dynamics_std, init_std, 0.0, 2e-4),
    "mb": _Model(vehicle_dynamics_mb, init_mb, 1.0, 5e-4),
}


class CommonRoad(Varied):
    """A vehicle of CommonRoad.

    Parameters
    ----------
    model : {"st", "std", "mb"}
        Single-track model with linear tyres; single-track drift model, whose tyres saturate;
        multi-body model with suspension, roll and four tyres.
    number : {1, 2, 3}
        Ford Escort, BMW 320i, VW Vanagon.
    params : PedalParams, optional
        What the pedals do. The model bounds the acceleration by what engine and tyres can do.
    dead_time : float, default 0.0
        Time from a command to its first effect on the wheels, which the closed loop adds [s].
    steer_offset : float, default 0.0
        Angle of the wheels at the command 0, which the closed loop adds [rad].

    Raises
    ------
    ConfigError
        No model or no vehicle is called like that, or a number is out of its range.

    Notes
    -----
    The pose is that of the middle of the rear axle. `vehicle` has the published axles and limits of
    the steering, 0.8 of the tyres' published grip, or less for a high vehicle (the VW Vanagon: 7.2
    m/s²), and an assumed lag of 0.1 s. The wheels turn to
    the angle commanded at up to 0.4 rad/s, the models' own limit.

    These limits end a run (`PlantLimit`):

    - all: a state that is not finite, as the multi-body model gives it beyond the grip of its
      tyres;
    - ``st``, whose tyres would hold any force: a lateral acceleration |v r| of more than the
      tyres' friction times gravity;
    - ``mb``: a speed below 1 m/s, where it does not work, so that it cannot start from rest nor
      roll backwards; and a wheel that leaves the road.

    ``st`` and ``std`` stop at rest. None of the models drives backwards.

    Examples
    --------
    >>> car = CommonRoad("mb", 2)
    >>> car.name, round(car.vehicle.wheelbase, 3), car.vehicle.max_steer_rate
    ('commonroad-mb-2', 2.579, 0.4)
    >>> car.reset(0.0, 0.0, 0.0, 10.0)
    >>> state = car.advance(0.05, 0.5, 0.0, 0.005, 10)
    >>> round(state.x, 2), round(state.steer, 3)
    (0.5, 0.02)
    """

    reverses = False

    def __init__(
        self,
        model: str,
        number: int,
        params: PedalParams | None = None,
        *,
        dead_time: float = 0.0,
        steer_offset: float = 0.0,
    ) -> None:
        check_known("model of CommonRoad", model, _MODELS)
        if number not in (1, 2, 3):
            raise ConfigError("vehicle of CommonRoad", number, "1, 2 or 3")
        self.name = f"commonroad-{model}-{number}"
        self.params = PedalParams() if params is None else params
        self._kind, self._model = model, _MODELS[model]
        self._of = model, number
        self._p = setup_vehicle_parameters(vehicle_id=number)
        self._grip = float(self._p.tire.p_dy1) * _GRAVITY
        self.vehicle = published(
            wheelbase=self._p.a + self._p.b,
            max_steer=self._p.steering.max,
            max_steer_rate=self._p.steering.v_max,
            grip=self._grip,
            overturning=0.5 * _GRAVITY * min(self._p.T_f, self._p.T_r) / self._p.h_cg,
            dead_time=dead_time,
            steer_offset=steer_offset,
        )
        self._x: list[float] = []

    @property
    def least_speed(self) -> float:
        """Least speed that it can start with [m/s]."""
        return self._model.least_speed

    def reset(self, x: float, y: float, yaw: float, speed: float, /) -> None:
        """Put the vehicle into a pose of its rear axle [m, m, rad], rolling straight ahead [m/s].

        Raises InputError where the model cannot start at this speed.
        """
        least = self._model.least_speed
        if not speed >= least:
            wanted = f"at least {least:g} m/s for {self.name} to start (--speed)"
            raise InputError("speed", speed, wanted)
        rear = self._p.b
        core = [x + rear * math.cos(yaw), y + rear * math.sin(yaw), 0.0, speed, yaw, 0.0, 0.0]
        self._x = [float(value) for value in self._model.initial(core, self._p)]

    def advance(
        self,
        steer: float,
        throttle: float,
        brake: float,
        dt: float,
        substeps: int,
        reverse: bool = False,  # noqa: FBT001, FBT002 - by place, as the protocol has it
        /,
    ) -> PlantState:
        """Move on under one command, as `PythonPlant.advance`; the model may take finer steps.

        Raises InputError where it is to drive backwards, and PlantLimit where the model is not
        valid any further.
        """
        if reverse:
            raise InputError("reverse", reverse, f"False, as {self.name} does not reverse")
        steering = self._p.steering
        wanted = min(max(steer, steering.min), steering.max)
        for _ in range(substeps):
            longest = self._model.step_per_speed * max(self._x[3], _KINEMATIC_SPEED)
            finer = math.ceil(dt / longest)
            for _ in range(finer):
                self._step(wanted, throttle, brake, dt / finer)
        return self._state()

    def _step(self, wanted: float, throttle: float, brake: float, dt: float) -> None:
        """Move on by one step of the integrator, and look whether the model still holds."""
        speed = self._x[3]
        rate = follow(wanted, self._x[2], self._p.steering.v_max, dt)
        # The brakes hold a vehicle at rest, they do not pull it backwards.
        acceleration = max(self.params.acceleration(throttle, brake, speed), -speed / dt)
        try:
            self._x = self._runge_kutta([rate, acceleration], dt)
        except (ArithmeticError, ValueError):
            raise self._lost_grip(speed, "the model has no solution") from None
        if not all(map(math.isfinite, self._x)):
            raise self._lost_grip(speed, "the model's state is no longer finite")
        self._check()

    def _runge_kutta(self, u: list[float], h: float) -> list[float]:
        derivative, x, p = self._model.derivative, self._x, self._p
        # Two of the models write into the state that they are given: each gets its own.
        k1 = derivative(list(x), u, p)
        k2 = derivative([a + 0.5 * h * b for a, b in zip(x, k1, strict=True)], u, p)
        k3 = derivative([a + 0.5 * h * b for a, b in zip(x, k2, strict=True)], u, p)
        k4 = derivative([a + h * b for a, b in zip(x, k3, strict=True)], u, p)
        return [
            a + h / 6.0 * (b + 2.0 * c + 2.0 * d + e)
            for a, b, c, d, e in zip(x, k1, k2, k3, k4, strict=True)
        ]

    def _check(self) -> None:
        """Raise where the model's own limits are passed."""
        x, least = self._x, self._model.least_speed
        if self._kind != "mb":
            x[3] = max(x[3], 0.0)  # what rounding leaves of a stop
        if x[3] < least:
            raise PlantLimit(f"speed {x[3]:.3f} m/s is below the model's {least:g} m/s")
        if self._kind == "st" and abs(x[3] * x[5]) > self._grip:
            raise PlantLimit(
                f"lateral acceleration at {x[3]:.1f} m/s reaches what the tyres hold,"
                f" {self._grip:.1f} m/s²"
            )
        if self._kind == "mb" and (wheel := self._lifted()) is not None:
            raise PlantLimit(f"the {wheel} wheel leaves the road at {x[3]:.1f} m/s")

    def _lifted(self) -> str | None:
        """Name a wheel without load: as the multi-body model computes F_z, less its stiffness."""
        x, p = self._x, self._p
        axles = ("front", x[13], x[16], p.T_f), ("rear", x[18], x[21], p.T_r)
        for axle, roll, height, track in axles:
            middle = height + p.R_w * (math.cos(roll) - 1.0)
            lean = 0.5 * track * math.sin(roll)
            if middle - lean < 0.0:
                return f"left {axle}"
            if middle + lean < 0.0:
                return f"right {axle}"
        return None

    def _lost_grip(self, speed: float, what: str) -> PlantLimit:
        wheel = self._x[2]
        wheels = f" and wheels at {math.degrees(wheel):.1f}°" if math.isfinite(wheel) else ""
        return PlantLimit(f"grip at {speed:.1f} m/s{wheels}: {what}")

    def _state(self) -> PlantState:
        """Report the rear axle, from the centre of mass that the models speak of."""
        x, rear = self._x, self._p.b
        along = x[3] if self._kind == "mb" else x[3] * math.cos(x[6])
        return PlantState(
            x=x[0] - rear * math.cos(x[4]),
            y=x[1] - rear * math.sin(x[4]),
            yaw=x[4],
            speed=along,
            yaw_rate=x[5],
            steer=x[2],
        )
