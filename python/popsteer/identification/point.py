"""The fit of the position: where the no-slip point lies, which moves along the car's heading.

A point that lies `d` behind the pose's point and does not slip moves along the heading. On tyres it
slips sideways with the lateral acceleration, v yaw', so that the pose's point moves

    v (cos yaw, sin yaw) - (rear_axle + slip v²) yaw' (-sin yaw, cos yaw)

`rear_axle + slip v²` is the position of the no-slip point at this speed. Also fitted are the angle
by which the measured heading is turned against the car's, and the scale of the measured speed: what
the car moves along and across the measured heading are its cosine and sine, so that atan2 has it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from popsteer.identification.arrays import huber, middles, recursion, summed
from popsteer.identification.whiten import (
    Error,
    Known,
    choose_theta,
    known,
    spread,
    theta_of,
    whitened,
)

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from popsteer.identification.drive import Array, PreparedLog

NAMES = ("rear_axle", "slip", "heading_bias", "speed_excess")
SLOW = 1.0
"""Time over which the heading's noise is taken out at least [s]: a filter's own is no white one."""
_TURNS = 4


@dataclass(frozen=True, eq=False)
class Point:
    """What the position says of the car."""

    values: dict[str, float]
    known: Known
    """How well, in the order of `NAMES`."""
    noise: float
    """Standard deviation of the innovations of the position [m]."""

    @property
    def errors(self) -> dict[str, float]:
        """The whole error of each value."""
        return dict(zip(NAMES, self.known.errors(), strict=True))

    def error_at(self, speed: float) -> float:
        """Give the whole error of `rear_axle + slip v²` [m]."""
        return self.known.error(_place(speed))

    def split(self, speed: float) -> Error:
        """Give the two parts of the error of `rear_axle + slip v²` [m]."""
        return self.known.split(_place(speed))


def _place(speed: float) -> Array:
    return np.array([1.0, speed**2, 0.0, 0.0])


def fit_point(
    drive: PreparedLog, simulated: Array, place: NDArray[np.complex128], theta: float
) -> Point:
    """Fit the point to a drive's positions, with the simulated heading [rad] and its `theta`.

    `place` is where the simulated no-slip point is, east + i north [m].
    """
    off = smooth(drive.yaw - simulated, max(theta, 1.0 - drive.usual_step / SLOW), drive)
    found = _fitted(drive, simulated + off, place, off)
    if abs(bias := found.values["heading_bias"]) > 1e-3:  # then the point's place is turned, too
        found = _fitted(drive, simulated + off + bias, place, off + bias)
        bias += found.values["heading_bias"]
    return replace(found, values=found.values | {"heading_bias": bias})


def _fitted(
    drive: PreparedLog, heading: Array, place: NDArray[np.complex128], turned: Array
) -> Point:
    """Fit with the steps of the simulated motion turned by an angle that changes slowly."""
    speed, ahead = middles(drive.sample_speed), np.diff(np.exp(1j * heading))
    moved = np.diff(place) * np.exp(1j * middles(turned))
    # The way between samples, and what each parameter adds to it.
    each = (moved, -ahead, -speed * speed * ahead, 1j * moved, moved)
    columns = [np.stack((one.real, one.imag), axis=1) for one in each]
    # Their integrals from the start on, (N, 2) and (N, P, 2).
    driven, grown = summed(columns[0]), summed(np.stack(columns[1:], axis=1))
    measured = np.stack((drive.x, drive.y), axis=1)
    parts = drive.parts()
    values = np.zeros(len(NAMES))
    memory = int(np.ceil(1.0 / drive.usual_step))
    root = np.ones((1, 1))  # of the weights
    least = drive.least_noise["position"] ** 2
    drift = float(np.mean((drive.speed_noise * np.diff(drive.t)) ** 2))
    for _ in range(_TURNS):
        left = measured - driven - np.einsum("kpi,p->ki", grown, values)
        theta = min(choose_theta(left, parts), theta_of(drift, least + _sample(left, parts)))
        white = whitened(measured - driven, parts, theta).ravel()
        # The order is x, y of a sample, then the next sample.
        jacobian = np.stack(
            [whitened(grown[:, p], parts, theta).ravel() for p in range(len(NAMES))], axis=1
        )
        scale = np.linalg.norm(jacobian, axis=0)
        scale[scale == 0.0] = 1.0
        values = np.linalg.lstsq(jacobian / scale * root, white * root[:, 0], rcond=1e-10)[0]
        values = values / scale
        residual = white - jacobian @ values
        noise = max(spread(residual), drive.least_noise["position"])
        root = huber(residual / noise, 2.0)[:, None]
    white = (jacobian * root).T @ (jacobian * root) / noise**2  # of no less noise than is believed
    rear, slip, across, along = map(float, values)
    angle, scale = math.atan2(across, 1.0 + along), math.hypot(across, 1.0 + along)
    return Point(
        values=dict(zip(NAMES, (rear, slip, angle, scale - 1.0), strict=True)),
        known=known(jacobian * root / noise, residual * root[:, 0] / noise, 2 * memory, white),
        noise=noise,
    )


def _sample(left: Array, parts: list[slice]) -> float:
    """Give the variance of the noise of a position [m²]."""
    return 0.5 * spread(np.concatenate([np.diff(left[part], axis=0) for part in parts])) ** 2


def smooth(values: Array, theta: float, drive: PreparedLog) -> Array:
    """Give a random walk out of the noise of its samples: exponential, forwards and backwards."""
    smooth = values.copy()  # what does not count stays as it was measured
    for place in drive.parts():
        part = values[place]
        first = max(1, min(len(part), round(1.0 / (1.0 - theta))))
        for _ in range(2):
            added = (1.0 - theta) * part
            added[0] += theta * float(np.mean(part[:first]))
            part = recursion(theta, added)[::-1]
        smooth[place] = part
    return smooth
