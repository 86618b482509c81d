"""The result of an identification: the vehicle, and its motion beside the measured one."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from popsteer.files import write_text_atomic
from popsteer.identification.arrays import chords, middles, parted, summed
from popsteer.identification.drive import SETTLING
from popsteer.vehicle_file import as_toml

if TYPE_CHECKING:
    import os
    from collections.abc import Iterable

    from numpy.typing import NDArray

    from popsteer._core import Vehicle
    from popsteer.identification.drive import Array, PreparedLog
    from popsteer.identification.fit import Fit
    from popsteer.identification.innovations import Octave
    from popsteer.identification.pedals import Drive
    from popsteer.identification.point import Point
    from popsteer.identification.signals import Signals
    from popsteer.logs import Log


@dataclass(frozen=True, eq=False)
class Identification:
    """A vehicle that was identified from a log, and how sure that is.

    Attributes
    ----------
    vehicle : Vehicle
        What was found; fields that the log does not show have the values that were given.
    errors : dict of str to float
        The standard error of each field that was found, in its own unit: how far the estimate
        would scatter if the same drive were logged again, with new noise.
    model_errors : dict of str to float
        How far a model that is not quite the car's may have moved each field, ``delay`` and
        ``turning_length`` besides: by what its residuals show beyond noise, and by how far other
        models lie off that explain the log as well; of a point that was given and is kept, also by
        how far it lies from the estimate. Independent of the standard error; a longer drive does
        not make it smaller.
    unknown : dict of str to str
        The fields that the log does not show: why, and what to drive to learn them. They have the
        values that were given, or assumed ones.
    ranges : dict of str to tuple of float
        Within which the unknown fields lie, two standard errors to both sides.
    delay, delay_error : float
        Dead time and lag together, and their standard error [s]: mostly better known than each.
    turning_length, turning_length_error : float
        The length by which the car turns at `speed`, and its standard error [m].
    speed : float
        The speed at which the car turned most [m/s].
    lag_of : {"wheels", "yaw rate", "tyres"}
        Where the lag is that explains the log best: between command and wheels; between wheels and
        yaw rate; the same, growing with the speed.
    notes : tuple of str
        In words, what the log does not show or cannot tell apart, and what was left out.
    noise : dict of str to float
        Standard deviations: ``yaw`` is the noise of a sample of the heading [rad], ``yaw_drift``
        by how much what the model leaves of the heading grows within 1 s [rad], ``position`` what
        it leaves of the position from sample to sample [m].
    excitation : dict of str to tuple of float
        What the drive went through, least and most: ``speed`` [m/s], ``curvature`` [1/m],
        ``steer_rate`` [rad/s], ``acceleration`` [m/s²]; ``stops``: how many, and their time [s].
    unexplained : tuple of str
        What the innovations have that no noise has: empty if the vehicle explains the log.
    octaves : tuple of Octave
        The power of the innovations in each octave, over that of white noise, and what noise alone
        does not reach.
    records : dict of str to ndarray
        Over the samples: ``t`` [s], ``x``, ``y``, ``simulated_x``, ``simulated_y`` [m],
        ``position_error`` [m] to the left, ``yaw_rate``, ``simulated_yaw_rate`` [rad/s], and
        whether a sample ``counts``. The simulation restarts at the measured pose every 10 s.
    log : Log
        The log as it was used: a row for each sample, its heading turned and its speed scaled.
    fit : Fit
        The fit of the heading, for its profile likelihoods.
    drive : Drive or None
        What is known of the drive, with its pedals; None if its commands were not logged.
    """

    vehicle: Vehicle
    errors: dict[str, float]
    model_errors: dict[str, float]
    unknown: dict[str, str]
    ranges: dict[str, tuple[float, float]]
    delay: float
    delay_error: float
    turning_length: float
    turning_length_error: float
    speed: float
    lag_of: str
    notes: tuple[str, ...]
    noise: dict[str, float]
    excitation: dict[str, tuple[float, float]]
    unexplained: tuple[str, ...]
    octaves: tuple[Octave, ...]
    records: dict[str, NDArray[Any]] = field(repr=False)
    log: Log = field(repr=False)
    fit: Fit = field(repr=False)
    drive: Drive | None = None

    @property
    def explains(self) -> bool:
        """Whether the vehicle explains the log: its innovations are no more than noise."""
        return not self.unexplained

    @property
    def verdict(self) -> str:
        """Whether the vehicle explains the log, in a sentence, and what it leaves."""
        if self.explains:
            return (
                "The vehicle explains the heading to within the noise of the log: what it leaves is"
                f" white, {self.noise['yaw']:.2g} rad a sample."
            )
        return f"The vehicle does not explain the heading: {'; '.join(self.unexplained)}."

    @property
    def driven(self) -> str:
        """What the drive went through, and what its drive does, in a sentence or two."""
        ranges = self.excitation
        units = {"speed": "m/s", "curvature": "1/m", "acceleration": "m/s²"}
        said = [
            f"{name} {ranges[name][0]:.2g} to {ranges[name][1]:.2g} {unit}"
            for name, unit in units.items()
            if name in ranges
        ]
        if "steer_rate" in ranges:
            stops, rest = ranges["stops"]
            said.append(f"steering up to {ranges['steer_rate'][1]:.2g} rad/s")
            said.append(f"{stops:.0f} stops of {rest:.0f} s in all")
        text = f"Driven: {', '.join(said)}."
        if self.drive is not None and self.drive.errors:
            each = [
                f"{name} {self.drive.values[name]:.3g} ± {error:.2g}"
                for name, error in self.drive.errors.items()
                if not name.startswith("drive_")
            ]
            text += f" The drive: {', '.join(each)}."
        return text

    def as_toml(self, given: Iterable[str] = ()) -> str:
        """Word the vehicle as a TOML file: for each number whether it was identified, and how well.

        The fields that are named as `given` are that also where they have their default.
        `popsteer.Vehicle.load` reads it, `popsteer.sim.PedalMap.load` its pedals.
        """
        said = dict.fromkeys(given, "given") | {
            name: f"identified: ± {math.hypot(error, self.model_errors[name]):.2g}"
            for name, error in self.errors.items()
        }
        pedals = {} if self.drive is None else self.drive.pedals
        errors = {} if self.drive is None else self.drive.errors
        return as_toml(
            self.vehicle,
            self.unknown,
            said,
            {name: (value, f"identified: ± {errors[name]:.2g}") for name, value in pedals.items()},
        )

    def save(self, file: str | os.PathLike[str]) -> None:
        """Write the vehicle to a TOML file, whole, as `as_toml` words it.

        Raises OSError where the file cannot be written.
        """
        write_text_atomic(file, self.as_toml())

    @property
    def yaw_rate_residual(self) -> float:
        """Root mean square of measured less simulated yaw rate, from sample to sample [rad/s]."""
        records = self.records
        left = records["yaw_rate"] - records["simulated_yaw_rate"]
        return float(np.sqrt(np.mean(left[records["counts"]] ** 2)))

    @property
    def yaw_rate_rms(self) -> float:
        """Root mean square of the measured yaw rate [rad/s]."""
        return float(np.sqrt(np.mean(self.records["yaw_rate"][self.records["counts"]] ** 2)))

    @property
    def position_residual(self) -> float:
        """Root mean square of the lateral distance after up to 10 s of simulation [m]."""
        errors = self.records["position_error"][self.records["counts"]]
        return float(np.sqrt(np.mean(errors**2)))


_NOTABLE_TURN = math.radians(0.2)
_NOTABLE_SPEED = 0.01


def described(given: Vehicle | None, found: Fit, point: Point, seen: Signals) -> list[str]:
    """Say what a reader should know beyond the figures, a sentence each."""
    notes = []
    if found.lag_of == "tyres" and "steer_lag" in found.names:
        notes.append(
            "the lag grows with the speed, as tyres have it; it is that of the usual speed"
        )
    bias = math.remainder(seen.heading_bias + point.values["heading_bias"], math.tau)
    excess = seen.speed_scale * (1.0 + point.values["speed_excess"]) - 1.0
    if abs(bias) > max(_NOTABLE_TURN, 4.0 * point.errors["heading_bias"]):
        side = "right" if bias > 0.0 else "left"
        notes.append(
            f"the measured heading points {math.degrees(abs(bias)):.2f} degrees to the {side} of"
            " where the car moves on a straight: turn the sensor's heading by that"
        )
    if abs(excess) > max(_NOTABLE_SPEED, 4.0 * point.errors["speed_excess"]):
        notes.append(
            f"the positions move {100.0 * excess:+.1f} % faster than the measured speed says: it is"
            f" taken times {seen.speed_scale:.3f} (--unit speed={seen.speed_scale:.4f})"
        )
    if given is None:
        notes.append(
            "no vehicle was given: the wheelbase is the one that the car turns by, and limits are"
            " defaults; measure wheelbase, rear axle and max_steer, and tell them"
        )
    return notes


AFRESH = 10.0
"""After this time the simulation restarts at the measured pose [s]."""


def compared(
    log: Log, drive: PreparedLog, yaw: Array, theta: float, point: Point
) -> dict[str, NDArray[Any]]:
    """Set the simulated motion beside the measured one: the records of an `Identification`.

    `yaw` is the simulated heading [rad], `theta` and `point` are as the fits give them.
    """
    from popsteer.identification.point import smooth

    heading = smooth(drive.yaw - yaw, theta, drive)  # what the measured heading is ahead
    rear, slip, bias = (point.values[name] for name in ("rear_axle", "slip", "heading_bias"))
    measured = drive.x + 1j * drive.y
    place, off = np.empty_like(measured), np.zeros_like(yaw)
    for part in parted(_starts(drive)[1:], len(yaw)):
        course, speed = yaw[part] + heading[part.start] + bias, middles(drive.sample_speed[part])
        aside = (rear + slip * speed**2) * np.diff(np.exp(1j * course))
        path = summed(speed * np.diff(drive.t[part]) * chords(course) - aside)
        # The mean of the first few, so that one sample's noise does not stay for 10 s.
        place[part] = path + np.mean((measured[part] - path)[:5])
        off[part] = ((measured[part] - place[part]) * np.exp(-1j * course)).imag
    counts = np.zeros(len(yaw), dtype=np.bool_)
    for part in drive.parts():
        counts[part.start + 1 : part.stop] = True
    step = np.diff(drive.t, prepend=drive.t[0] - drive.usual_step)
    return {
        "t": np.array(log.t),
        "x": np.array(log.x),
        "y": np.array(log.y),
        "simulated_x": place.real,
        "simulated_y": place.imag,
        "position_error": off,
        "yaw_rate": np.diff(drive.yaw, prepend=drive.yaw[0]) / step,
        "simulated_yaw_rate": np.diff(yaw, prepend=yaw[0]) / step,
        "counts": counts,
    }


def _starts(drive: PreparedLog) -> list[int]:
    """Give the samples at which the simulation restarts."""
    found: list[int] = []
    for part in drive.unbroken:
        t = drive.t[part]
        # What does not count, as nobody knows what was commanded before, is no beginning either.
        marks = np.append(t[0], np.arange(t[0] + SETTLING, t[-1] - 1e-9, AFRESH))
        found += (part.start + np.searchsorted(t, marks)).tolist()
    return found
