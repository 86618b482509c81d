//! The parameters of the lateral controllers.

use popsteer_core::laws::{
    PidParams, PopParams, PreviewPopParams, PurePursuitParams, StanleyParams,
};
use pyo3::prelude::*;

use crate::params::params;
use crate::vehicle::PyVehicle;

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
