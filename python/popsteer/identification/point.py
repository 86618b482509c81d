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
    from popsteer.identification.drive import Array, PreparedLog

NAMES = ("rear_axle", "slip", "heading_bias", "speed_excess")
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


def fit_point(drive: PreparedLog, simulated: Array, theta: float, bias: float = 0.0) -> Point:
    """Fit the point to a drive's positions, with the simulated heading [rad] and its `theta`.

    `bias` is by how much the measured heading points to the right, roughly [rad].
    """
    heading = simulated + smooth(drive.yaw - simulated, theta, drive) + bias
    found = _fitted(drive, heading)
    more = found.values["heading_bias"]
    if abs(more) > 1e-3:  # where it is not small, the place of the point is turned, too
        found = _fitted(drive, heading + more)
        bias += more
    bias = math.remainder(bias + found.values["heading_bias"], math.tau)
    return replace(found, values=found.values | {"heading_bias": bias})


def _fitted(drive: PreparedLog, heading: Array) -> Point:
    columns = _columns(drive, heading)
    base, regressors = columns[0], np.stack(columns[1:], axis=1)
    # Their integrals from the start on, (N, 2) and (N, P, 2).
    driven = np.concatenate((np.zeros((1, 2)), np.cumsum(base, axis=0)))
    grown = np.concatenate((np.zeros((1, *regressors.shape[1:])), np.cumsum(regressors, axis=0)))
    measured = np.stack((drive.x, drive.y), axis=1)
    parts = drive.parts()
    values = np.zeros(len(NAMES))
    memory = int(np.ceil(1.0 / float(np.median(np.diff(drive.t)))))
    weight = np.ones(0)
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
        weight = weight if len(weight) else np.ones(len(white))
        root = np.sqrt(weight)[:, None]
        scale = np.linalg.norm(jacobian, axis=0)
        scale[scale == 0.0] = 1.0
        values = np.linalg.lstsq(jacobian / scale * root, white * root[:, 0], rcond=1e-10)[0]
        values = values / scale
        residual = white - jacobian @ values
        noise = max(spread(residual), drive.least_noise["position"])
        weight = np.minimum(1.0, 2.0 * noise / np.maximum(np.abs(residual), 1e-12))
        root = np.sqrt(weight)[:, None]
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


def _columns(drive: PreparedLog, heading: Array) -> list[Array]:
    """Give the way between samples, and what each parameter adds to it, (N - 1, 2) each."""
    step, turn = np.diff(drive.t), np.diff(heading)
    middle = heading[:-1] + 0.5 * turn
    speed = 0.5 * (drive.sample_speed[1:] + drive.sample_speed[:-1])
    along = np.stack((np.cos(middle), np.sin(middle)), axis=1)
    across = np.stack((-along[:, 1], along[:, 0]), axis=1)
    # Chords of the arcs that are driven between samples.
    way = (speed * step * np.sinc(0.5 * turn / np.pi))[:, None]
    turn = 2.0 * np.sin(0.5 * turn)
    return [
        way * along,
        -turn[:, None] * across,
        -(speed * speed * turn)[:, None] * across,
        way * across,
        way * along,
    ]


def smooth(values: Array, theta: float, drive: PreparedLog) -> Array:
    """Give a random walk out of the noise of its samples: exponential, forwards and backwards."""
    from scipy.signal import lfilter

    smooth = values.copy()  # what does not count stays as it was measured
    for place in drive.parts():
        part = values[place]
        first = max(1, min(len(part), round(1.0 / (1.0 - theta))))
        for _ in range(2):
            begun = [theta * float(np.mean(part[:first]))]
            part = lfilter([1.0 - theta], [1.0, -theta], part, zi=begun)[0][::-1]
        smooth[place] = part
    return smooth
