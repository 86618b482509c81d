"""A car in MuJoCo: four wheels that roll and slip on a road, as rigid bodies.

Its model is ``mujoco_car.xml`` beside this file.
"""

from __future__ import annotations

import math
from importlib import resources
from typing import Any

import mujoco

from popsteer.errors import PlantLimit
from popsteer.plants.pedals import MujocoCarParams
from popsteer.plants.protocol import PlantState, Varied, follow, published

# As in the model file.
_WHEELBASE, _TRACK, _RADIUS, _CENTRE_HEIGHT = 2.7, 1.56, 0.33, 0.5
_MOST_STEER = 0.6
# Brakes hold with their full torque from this rate of turn of a wheel on [rad/s]: below, with less,
# so that they do not shake a standing car.
_BRAKE_RATE = 1.0
# What keeps the wheels from spinning ever faster: the torque fades, and is gone where a wheel slips
# by this much [m/s].
_MOST_SLIP = 2.0
_UPRIGHT = math.cos(math.radians(30.0))


class MujocoCar(Varied):
    """A car in MuJoCo.

    1500 kg, axles 2.7 m apart, 54 % of the weight on the front one, 1.56 m between the wheels of an
    axle, each wheel sprung and driven. The front wheels turn about their uprights by the two angles
    that Ackermann's geometry gives for the one commanded, at most 0.6 rad and at most as fast as
    `steer_rate`. The wheels are ellipsoids of 0.33 m radius on Coulomb friction; the pedals turn
    them, and the torque of a wheel that slips fades.

    Parameters
    ----------
    params : MujocoCarParams, optional
        Pedals, friction, and rate of the steering.
    dead_time : float, default 0.0
        Time from a command to its first effect on the wheels, which the closed loop adds [s].
    steer_offset : float, default 0.0
        Angle of the wheels at the command 0, which the closed loop adds [rad].

    Raises
    ------
    ConfigError
        A number is out of its range.

    Notes
    -----
    The pose is that of the middle of the rear axle. `vehicle` has the axles and the limits of the
    steering, 0.8 of the friction times gravity, and an assumed lag of 0.1 s. Where the tyres no
    longer hold, the car slides; a run ends (`PlantLimit`) where it tilts by more than 30°, or where
    the solver gives up. The steps of MuJoCo are at most 2 ms.

    Examples
    --------
    >>> car = MujocoCar()
    >>> car.reset(0.0, 0.0, 0.0, 10.0)
    >>> state = car.advance(0.0, 0.5, 0.0, 0.005, 10)
    >>> abs(state.x - 0.5) < 0.01, abs(state.y) < 1e-3
    (True, True)
    >>> car.vehicle.wheelbase, car.vehicle.max_steer, car.reverses
    (2.7, 0.6, True)
    """

    name = "mujoco-car"
    reverses = True

    def __init__(
        self,
        params: MujocoCarParams | None = None,
        *,
        dead_time: float = 0.0,
        steer_offset: float = 0.0,
    ) -> None:
        self.params = MujocoCarParams() if params is None else params
        model = resources.files("popsteer.plants").joinpath("mujoco_car.xml")
        self._model: Any = mujoco.MjModel.from_xml_string(model.read_text(encoding="utf-8"))
        self._model.geom_friction[:, 0] = self.params.friction
        self._data: Any = mujoco.MjData(self._model)
        self._mass = float(self._model.body_mass.sum())
        self._body = int(self._model.body("car").id)
        self._spin = [
            int(self._model.joint(f"spin {wheel}").dofadr[0])
            for wheel in ("front left", "front right", "rear left", "rear right")
        ]
        self._longest = float(self._model.opt.timestep)
        for _ in range(500):  # until the tyres carry the weight
            mujoco.mj_step(self._model, self._data)
        self._height = float(self._data.qpos[2])
        self._steer = 0.0
        self.vehicle = published(
            wheelbase=_WHEELBASE,
            max_steer=_MOST_STEER,
            max_steer_rate=self.params.steer_rate,
            overturning=0.5 * _TRACK / _CENTRE_HEIGHT * float(-self._model.opt.gravity[2]),
            grip=self.params.friction * float(-self._model.opt.gravity[2]),
            dead_time=dead_time,
            steer_offset=steer_offset,
        )

    def reset(self, x: float, y: float, yaw: float, speed: float, /) -> None:
        """Put the car into a pose of its rear axle [m, m, rad], rolling straight ahead [m/s]."""
        data = self._data
        mujoco.mj_resetData(self._model, data)
        half = 0.5 * yaw
        data.qpos[:7] = x, y, self._height, math.cos(half), 0.0, 0.0, math.sin(half)
        data.qvel[:2] = speed * math.cos(yaw), speed * math.sin(yaw)
        data.qvel[self._spin] = speed / _RADIUS
        self._steer = 0.0
        mujoco.mj_forward(self._model, data)

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
        """Move on under one command, as `PythonPlant.advance`; MuJoCo may take finer steps.

        Raises PlantLimit where it has tilted over, or the solver gave up.
        """
        wanted = _within(steer, -_MOST_STEER, _MOST_STEER)
        finer = math.ceil(dt / self._longest)
        step = self._model.opt.timestep = dt / finer
        for _ in range(substeps * finer):
            self._steer += step * follow(wanted, self._steer, self.params.steer_rate, step)
            self._push(throttle, brake, -1.0 if reverse else 1.0)
            mujoco.mj_step(self._model, self._data)
        self._check()
        return self._state()

    def _push(self, throttle: float, brake: float, gear: float) -> None:
        """Set the actuators, and the drag; `gear` is -1 where the throttle drives backwards."""
        data, params = self._data, self.params
        curvature = math.tan(self._steer) / _WHEELBASE
        drive = gear * params.drive * throttle * self._mass * _RADIUS / 4.0
        hold = params.braking * brake * self._mass * _RADIUS / 4.0
        rolling = math.hypot(data.qvel[0], data.qvel[1])
        torques = [
            drive * _within(1.0 - (gear * rate * _RADIUS - rolling) / _MOST_SLIP, 0.0, 1.0)
            - hold * _within(rate / _BRAKE_RATE, -1.0, 1.0)
            for rate in data.qvel[self._spin].tolist()
        ]
        data.ctrl[:] = (
            math.atan(_WHEELBASE * curvature / (1.0 - 0.5 * _TRACK * curvature)),
            math.atan(_WHEELBASE * curvature / (1.0 + 0.5 * _TRACK * curvature)),
            *torques,
        )
        data.xfrc_applied[self._body, :2] = -params.drag * self._mass * data.qvel[:2]

    def _check(self) -> None:
        """Raise where the car is no longer one that drives."""
        data = self._data
        kinds = mujoco.mjtWarning
        bad = kinds.mjWARN_BADQPOS, kinds.mjWARN_BADQVEL, kinds.mjWARN_BADQACC
        if any(data.warning[kind].number for kind in bad):
            raise PlantLimit("MuJoCo's solver gave up: its state is no longer finite")
        if not data.xmat[self._body][8] >= _UPRIGHT:  # of the body's z axis, the part that is up
            raise PlantLimit("the car tilts by more than 30°")

    def _state(self) -> PlantState:
        data = self._data
        matrix = data.xmat[self._body]
        yaw = math.atan2(matrix[3], matrix[0])
        vx, vy = data.qvel[:2].tolist()
        return PlantState(
            x=float(data.qpos[0]),
            y=float(data.qpos[1]),
            yaw=yaw,
            speed=vx * math.cos(yaw) + vy * math.sin(yaw),
            yaw_rate=float(data.qvel[5]),
            steer=self._steer,
        )


def _within(value: float, low: float, high: float) -> float:
    return min(max(value, low), high)
