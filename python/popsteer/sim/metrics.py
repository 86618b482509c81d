"""The metrics of a run."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from popsteer.status import Status

if TYPE_CHECKING:
    from popsteer._core import Simulation


@dataclass(frozen=True)
class Metrics:
    """The metrics of a run.

    Errors are those of the point that the controller tracks, as the paper measured; with the prefix
    `rear_axle_` they are those of the rear axle, one point for all controllers. `settled_` leaves
    out the settling time at the start. A statistic of no values is NaN.

    Examples
    --------
    >>> import popsteer
    >>> from popsteer.sim import Simulation
    >>> path = popsteer.Path([(0.0, 0.0), (50.0, 0.0)])
    >>> simulation = Simulation(path, start=(0.0, 0.5, 0.0))
    >>> simulation.step(steer=0.1)
    >>> Metrics.of(simulation).max_abs_cross_track_error
    0.5
    """

    mean_abs_cross_track_error: float
    """Mean of the absolute cross-track error [m]."""
    rms_cross_track_error: float
    """Root of the mean square of the cross-track error [m]."""
    max_abs_cross_track_error: float
    """Largest absolute cross-track error [m]."""
    mean_abs_heading_error: float
    """Mean of the absolute heading error [rad]."""
    rms_heading_error: float
    """Root of the mean square of the heading error [rad]."""
    max_abs_heading_error: float
    """Largest absolute heading error [rad]."""
    settled_mean_abs_cross_track_error: float
    """Mean of the absolute cross-track error after the settling time [m]."""
    settled_rms_cross_track_error: float
    """Root of the mean square of the cross-track error after the settling time [m]."""
    settled_max_abs_cross_track_error: float
    """Largest absolute cross-track error after the settling time [m]."""
    settled_mean_abs_heading_error: float
    """Mean of the absolute heading error after the settling time [rad]."""
    settled_rms_heading_error: float
    """Root of the mean square of the heading error after the settling time [rad]."""
    settled_max_abs_heading_error: float
    """Largest absolute heading error after the settling time [rad]."""
    rear_axle_mean_abs_cross_track_error: float
    """Mean of the absolute cross-track error of the rear axle [m]."""
    rear_axle_rms_cross_track_error: float
    """Root of the mean square of the cross-track error of the rear axle [m]."""
    rear_axle_max_abs_cross_track_error: float
    """Largest absolute cross-track error of the rear axle [m]."""
    rear_axle_mean_abs_heading_error: float
    """Mean of the absolute heading error at the rear axle [rad]."""
    rear_axle_rms_heading_error: float
    """Root of the mean square of the heading error at the rear axle [rad]."""
    rear_axle_max_abs_heading_error: float
    """Largest absolute heading error at the rear axle [rad]."""
    rear_axle_settled_mean_abs_cross_track_error: float
    """Mean of the absolute cross-track error of the rear axle after the settling time [m]."""
    rear_axle_settled_rms_cross_track_error: float
    """Root of the mean square of the rear axle's cross-track error after the settling time [m]."""
    rear_axle_settled_max_abs_cross_track_error: float
    """Largest absolute cross-track error of the rear axle after the settling time [m]."""
    rear_axle_settled_mean_abs_heading_error: float
    """Mean of the absolute heading error at the rear axle after the settling time [rad]."""
    rear_axle_settled_rms_heading_error: float
    """Root of the mean square of the rear axle's heading error after the settling time [rad]."""
    rear_axle_settled_max_abs_heading_error: float
    """Largest absolute heading error at the rear axle after the settling time [rad]."""
    max_abs_steer: float
    """Largest absolute angle commanded [rad]."""
    rms_steer_rate: float
    """Root of the mean square of the steering rate commanded [rad/s]."""
    mean_speed: float
    """Mean speed, forward or backwards [m/s]."""
    time: float
    """Time driven [s]."""
    steps: int
    """Control steps."""
    finished: bool
    """Whether the end of the path was reached. That alone is no success: see `faults`, too."""
    faults: Status = Status.OK
    """The faults that the controller reported in any of the steps; `Status.OK` for none."""

    @classmethod
    def of(cls, simulation: Simulation) -> Metrics:
        """Take the metrics of a simulation so far.

        Parameters
        ----------
        simulation : Simulation
            The simulation, over or not.

        Returns
        -------
        Metrics
            Its metrics at this moment.
        """
        measured = simulation.metrics()
        return cls(**measured | {"faults": Status(measured["faults"])})
