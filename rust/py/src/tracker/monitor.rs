//! How a controller watches its vehicle.

use popsteer_core::tracker::MonitorParams;
use pyo3::prelude::*;

use crate::choice::{Choice, Chosen};
use crate::params::params;

popsteer_core::MonitorParams! { params {
    /// The thresholds beyond which a controller reports a fault, by two statuses of that level.
    ///
    /// ``Status.DEVIATING``: the measured cross-track error is beyond `deviation_limit`, after the
    /// vehicle was within it, by more than five standard deviations of the position's noise.
    ///
    /// ``Status.IMPLAUSIBLE``: the turns measured add up beyond those that the commands explain
    /// (Page's cumulative sum) by more than `turn_tolerance` and eight standard deviations of the yaw's
    /// noise: at most one of four million steps of a vehicle that is as told. The status stays for 2 s.
    /// The commands explain the turns ``gain (E + offset S)``: ``E`` is the turn that the vehicle's
    /// parameters expect, with a response quicker by up to 0.03 s or slower by up to 0.1 s; ``S`` is the
    /// turn by a radian of steering offset; gain and offset are the estimated ones and those told, as
    /// far as they are known, with 15 % of the gain for tyres and 0.012 rad for play. Without estimates
    /// they are 0.4 to 2.5 and 2 degrees to either side. A localisation whose yaw jumps is implausible,
    /// too. Nothing is concluded across inputs that were refused, periods longer than 0.7 s, changes of
    /// the direction of driving, and `relocalise`.
    PyMonitorParams(MonitorParams) named "MonitorParams" in "popsteer";
    @examples {
        /// A vehicle that comes off the path:
        ///
        /// >>> path = popsteer.Path([(0.0, 0.0), (100.0, 0.0)])
        /// >>> limit = popsteer.MonitorParams(deviation_limit=0.5)
        /// >>> stanley = popsteer.Stanley(path, monitor=limit)
        /// >>> stanley.step(1.0, 0.4, 0.0, 5.0, 0.05).status.level
        /// 'ok'
        /// >>> for y in (0.5, 0.6, 0.7, 0.8):
        /// ...     command = stanley.step(1.0 + 2.5 * (y - 0.4), y, 0.0, 5.0, 0.05)
        /// >>> str(command.status)
        /// 'deviating'
    }
} }

impl Chosen for PyMonitorParams {
    const REQUIRED: &'static str = "monitor must be MonitorParams, None or 'auto'";
}

/// The thresholds of a controller's monitor.
pub(crate) type Monitored = Choice<PyMonitorParams>;
