//! The lateral controllers, with their parameters.

use std::sync::Arc;

use popsteer_core::laws::{
    Pid, PidParams, Pop, PopParams, PreviewPop, PreviewPopParams, PurePursuit, PurePursuitParams,
    Stanley, StanleyParams,
};
use popsteer_core::tracker::{Reported, Tracker, TrackerState};
use popsteer_core::vehicle::Known;
use popsteer_core::{LateralLaw, Path, Vehicle, VehicleState};
use popsteer_sim::Law;
use popsteer_sim::batch::Member;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::errors::Raises;
use crate::params::{NewArgs, Number, count, number, params};
use crate::path::PyPath;
use crate::tracker::command::PyCommand;
use crate::tracker::controller::{controller, track};
use crate::tracker::monitor::{Monitored, PyMonitorParams};
use crate::tracker::prediction;
use crate::tracker::state;
use crate::vehicle::{Adapt, PyAdaptParams, PyEstimate, PyVehicle};

/// [`params!`] of a controller, with `resolved`.
macro_rules! tuning {
    (
        {
            $(#[doc = $about:literal])+
            $class:ident($core:ident) named $name:literal;
            @examples $examples:tt
        }
        $($fields:tt)+
    ) => {
        params! {
            {
                $(#[doc = $about])+
                ///
                /// What is not given and has no number here scales with the wheelbase of the
                /// vehicle: `resolved` gives the numbers.
                $class($core) named $name in "popsteer";
                @examples $examples
                @extra {
                    /// The same with the defaults that scale with a vehicle filled in.
                    ///
                    /// Parameters
                    /// ----------
                    /// vehicle : Vehicle
                    ///     The vehicle.
                    ///
                    /// Returns
                    /// -------
                    /// same as the object
                    ///     The parameters, with a number for each.
                    fn resolved(&self, vehicle: PyRef<'_, PyVehicle>) -> Self {
                        Self(self.0.resolved(&vehicle.0).into())
                    }
                }
            }
            $($fields)+
        }
    };
}

popsteer_core::PopParams! { tuning {
    /// Parameters of `Pop`; the paper's Table 1 at the paper's car.
    PyPopParams(PopParams) named "PopParams";
    @examples {
        /// >>> popsteer.PopParams().resolved(popsteer.Vehicle(wheelbase=0.5)).min_lookahead
        /// 1.0
    }
} }

popsteer_core::PreviewPopParams! { tuning {
    /// Parameters of `PreviewPop`.
    PyPreviewPopParams(PreviewPopParams) named "PreviewPopParams";
    @examples {
        /// >>> popsteer.PreviewPopParams().resolved(popsteer.Vehicle(wheelbase=2.7)).heading_cost
        /// 2.7
    }
} }

popsteer_core::PidParams! { tuning {
    /// Parameters of `Pid`; the paper's Table 1 at the paper's car.
    PyPidParams(PidParams) named "PidParams";
    @examples {
        /// >>> popsteer.PidParams().resolved(popsteer.Vehicle(wheelbase=0.3)).kp
        /// 2.5
    }
} }

popsteer_core::PurePursuitParams! { tuning {
    /// Parameters of `PurePursuit`; the paper's Table 1 at the paper's car, with the published
    /// code's least lookahead.
    PyPurePursuitParams(PurePursuitParams) named "PurePursuitParams";
    @examples {
        /// >>> popsteer.PurePursuitParams().resolved(popsteer.Vehicle(wheelbase=0.3)).min_lookahead
        /// 1.0
    }
} }

popsteer_core::StanleyParams! { tuning {
    /// Parameters of `Stanley`; the paper's Table 1 at the paper's car.
    PyStanleyParams(StanleyParams) named "StanleyParams";
    @examples {
        /// >>> popsteer.StanleyParams().resolved(popsteer.Vehicle(wheelbase=3.0)).lost_distance
        /// 30.0
    }
} }

/// The optional inputs of a step.
fn reported(
    applied: Option<Number>,
    measured: Option<Number>,
    [pose_age, roll]: [f64; 2],
) -> Reported {
    Reported {
        applied_steer: applied.map(|steer| steer.0),
        measured_steer: measured.map(|steer| steer.0),
        pose_age,
        roll,
    }
}

controller! {
    /// POP: proximally optimal predictive steering, the paper's Algorithm 1.
    ///
    /// Of the angles in the neighbourhood of the last one, chooses the angle whose predicted
    /// location (Equation 6) lies closest to the lookahead point. The last angle wins ties, so a
    /// vehicle at rest keeps its wheels still. Tracked point: the front axle.
    PyPop(Pop) named "Pop", params PyPopParams,
    examples {
        /// >>> path = popsteer.Path([(0.0, 0.0), (10.0, 0.0), (20.0, 0.0)])
        /// >>> car = popsteer.Vehicle(wheelbase=2.7, rear_axle=-1.35)
        /// >>> pop = popsteer.Pop(path, car)
        /// >>> command = pop.step(0.0, 0.5, 0.0, 5.0, 0.05)
        /// >>> command.steer < 0.0, command.cross_track_error
        /// (True, 0.5)
    }
}

controller! {
    /// Preview POP: POP's neighbourhood, judged by where it leads over a horizon.
    ///
    /// Of the angles in the neighbourhood of the last one, chooses the angle with the least cost
    /// over a horizon: ``e^2 + (heading_cost p)^2 + (steer_rate_cost rate)^2`` a step, with the
    /// cross-track error e, the heading error p and the rate of the wheels, predicted by a bicycle
    /// with lag along the curvature of the path ahead. The moves after the first one are assumed
    /// optimal, so the cost of an angle is a parabola, whose minimum is known in closed form. Where
    /// that plan leaves the neighbourhood or breaks a limit of the vehicle, at any step, the best
    /// plan within them takes its place. By default it adapts to its vehicle. Tracked point: the
    /// no-slip point.
    PyPreviewPop(PreviewPop) named "PreviewPop", params PyPreviewPopParams,
    examples {
        /// >>> path = popsteer.Path([(0.0, 0.0), (10.0, 0.0), (20.0, 0.0)])
        /// >>> car = popsteer.Vehicle(wheelbase=2.7, steer_lag=0.15, dead_time=0.15)
        /// >>> preview = popsteer.PreviewPop(path, car)
        /// >>> command = preview.step(0.0, 0.5, 0.0, 5.0, 0.05)
        /// >>> command.steer < 0.0, command.cross_track_error
        /// (True, 0.5)
    }
}

controller! {
    /// PID on the cross-track error at the front axle, the paper's Equation 1.
    ///
    /// ``steer = -(kp e + ki sum(e dt) + kd (e - e_previous) / dt)``, the sum over the last
    /// `buffer_length` steps. Tracked point: the front axle.
    PyPid(Pid) named "Pid", params PyPidParams,
    examples {
        /// >>> path = popsteer.Path([(0.0, 0.0), (10.0, 0.0), (20.0, 0.0)])
        /// >>> popsteer.Pid(path).steer(0.0, 0.5, 0.0, 5.0, 0.05)
        /// -0.12525
    }
}

controller! {
    /// Adaptive pure pursuit, the paper's Equation 2.
    ///
    /// ``steer = atan(2 wheelbase sin(alpha) / lookahead)`` with ``lookahead =
    /// max(min_lookahead, lookahead_gain speed)`` and ``alpha`` the bearing of the lookahead
    /// point off the heading. Tracked point: the rear axle.
    PyPurePursuit(PurePursuit) named "PurePursuit", params PyPurePursuitParams,
    examples {
        /// >>> path = popsteer.Path([(0.0, 0.0), (10.0, 0.0), (20.0, 0.0)])
        /// >>> round(popsteer.PurePursuit(path).steer(0.0, 0.5, 0.0, 5.0, 0.05), 4)
        /// -0.03
    }
}

controller! {
    /// The Stanley controller, the paper's Equation 3.
    ///
    /// ``steer = -(heading_error + atan(cross_track_gain cross_track_error / (softening +
    /// speed_gain speed)))``. Tracked point: the front axle.
    PyStanley(Stanley) named "Stanley", params PyStanleyParams,
    examples {
        /// >>> path = popsteer.Path([(0.0, 0.0), (10.0, 0.0), (20.0, 0.0)])
        /// >>> round(popsteer.Stanley(path).steer(0.0, 0.5, 0.0, 5.0, 0.05), 4)
        /// -0.0997
    }
}

/// `$then!` for the controllers: of each the core's law, its class, and that of its parameters.
macro_rules! all_laws {
    ($then:ident) => {
        $then! {
            Pop(PyPop, PyPopParams),
            PreviewPop(PyPreviewPop, PyPreviewPopParams),
            Pid(PyPid, PyPidParams),
            PurePursuit(PyPurePursuit, PyPurePursuitParams),
            Stanley(PyStanley, PyStanleyParams)
        }
    };
}
pub(crate) use all_laws;

/// Any of the controllers as the closed loop takes it, and its path; none for another object.
pub(crate) fn law_of(object: &Bound<'_, PyAny>) -> Option<(Tracker<Law>, Arc<Path>)> {
    macro_rules! try_each {
        ($($law:ident($class:ty, $params:ty)),+) => {$(
            if let Ok(controller) = object.cast_exact::<$class>() {
                let Member { tracker, path, .. } = controller.try_borrow().ok()?.member();
                return Some((tracker.map(Law::from), path));
            }
        )+};
    }
    all_laws!(try_each);
    None
}
