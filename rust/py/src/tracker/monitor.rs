//! How a controller watches its vehicle.

use popsteer_core::tracker::MonitorParams;
use pyo3::prelude::*;

use crate::choice::{Choice, Chosen};
use crate::params::params;

popsteer_core::MonitorParams! { params {
    /// The thresholds beyond which a controller reports a fault, by two statuses of that level.
    ///
    /// ``Status.DEVIATING``: the measured cross-track error is beyond `deviation_limit`, after the
    /// vehicle was within it.
    ///
    /// ``Status.IMPLAUSIBLE``: the turn measured over the last second is farther than
    /// `turn_tolerance` and five standard deviations of the yaw's noise from every turn that the
    /// commands explain. The status stays for 2 s. The commands explain the turns ``gain (E +
    /// offset S)``: ``E`` is the turn that the vehicle's parameters expect, with a response quicker
    /// by up to 0.03 s or slower by up to 0.1 s; ``S`` is the turn by a radian of steering offset;
    /// the gain is from 0.4 to 2.5, and the offset the one that the motion has shown. A steering
    /// offset of more than some 1.5 degrees that the vehicle's parameters lack is implausible until
    /// the motion has shown it, and so is a localisation whose yaw jumps. Nothing is concluded
    /// across inputs that were refused, periods longer than 0.7 s, changes of the direction of
    /// driving, and `relocalise`; the longer a period is, the fewer faults stand out, from 0.5 s on
    /// only the large ones.
    PyMonitorParams(MonitorParams) named "MonitorParams" in "popsteer";
    @examples {
        /// A vehicle that comes off the path:
        ///
        /// >>> path = popsteer.Path([(0.0, 0.0), (100.0, 0.0)])
        /// >>> limit = popsteer.MonitorParams(deviation_limit=0.5)
        /// >>> stanley = popsteer.Stanley(path, monitor=limit)
        /// >>> stanley.step(1.0, 0.4, 0.0, 5.0, 0.05).status.level
        /// 'ok'
        /// >>> str(stanley.step(1.25, 0.6, 0.0, 5.0, 0.05).status)
        /// 'deviating'
    }
} }

impl Chosen for PyMonitorParams {
    const REQUIRED: &'static str = "monitor must be MonitorParams, None or 'auto'";
}

/// The thresholds of a controller's monitor.
pub(crate) type Monitored = Choice<PyMonitorParams>;
