//! How a controller watches its vehicle.

use popsteer_core::lateral::MonitorParams;
use pyo3::prelude::*;

use crate::choice::{Choice, Chosen};
use crate::params::params;

params! {
    /// From where on a controller says that something is wrong: two statuses of the level fault.
    ///
    /// ``Status.DEVIATING`` where the measured cross-track error is beyond `deviation_limit`, once
    /// the vehicle has been within it. ``Status.IMPLAUSIBLE`` where the yaw measured over the last
    /// second is farther than `turn_tolerance` and five standard deviations of its noise from what
    /// the commands explain, and for 2 s after: with the turn ``E`` that the vehicle's parameters
    /// expect of them, quicker by 0.03 s to slower by 0.1 s, and the turn ``S`` of a radian of
    /// steering offset, all turns ``gain (E + offset S)`` with a gain from 0.4 to 2.5 and the
    /// offset that the motion has shown. Nothing is concluded across inputs that were refused,
    /// periods longer than 0.3 s, changes of the direction, and `relocalise`. A steering offset of
    /// more than some 1.5 degrees that the vehicle's parameters lack is implausible until the
    /// motion has shown it, and so is a localisation whose yaw jumps.
    PyMonitorParams(MonitorParams) named "MonitorParams" in "popsteer",
    shown as "(*, deviation_limit=None, turn_tolerance=0.01)",
    defaults MonitorParams::DEFAULT, checked by MonitorParams::checked,
    deviation_limit: Option<f64>, "float, optional",
        "Cross-track error from which a vehicle that was within it is deviating [m]. Half a wheelbase by default; 1e9 switches it off.";
    turn_tolerance: f64, "float, default 0.01",
        "Largest difference of the turn measured over a second to the turns that the commands explain, besides noise [rad]; 1e9 switches it off. Smaller: faults are found sooner, false alarms are likelier.";
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
}

impl Chosen for PyMonitorParams {
    const REQUIRED: &'static str = "monitor must be MonitorParams, None or 'auto'";
}

/// The thresholds of a controller's monitor.
pub(crate) type Monitored = Choice<PyMonitorParams>;
