//! The curve that the speed is led along: the plan, or the speed from which the vehicle still stops.

use crate::math::{larger, powf, saturate, smaller, sqrt};
use crate::path::PathView;

use crate::speed::defaults;
use crate::speed::law::limits::{CREEP, SpeedLaw};
use crate::speed::stops::{Between, PlanAt, Planned};

/// The end of a stop takes so many times the drive's delay and lag. Less: a drive that is later than the
/// vehicle says overruns. More: the stop takes longer.
const SOFT: f64 = 1.5;

impl SpeedLaw {
    pub(in crate::speed) fn planned<'a, 'b>(
        &self,
        path: &'a PathView<'b>,
        speeds: &'a [f64],
        segment: usize,
    ) -> Planned<'a, 'b> {
        Planned {
            path,
            speeds,
            segment,
            end: path.section_end(segment),
            between: Between {
                accelerations: self.accelerations,
                most: self.car.max_speed.unwrap_or(defaults::MAX_SPEED),
            },
        }
    }

    /// `z*` and its change in time at `arc` [m], with `y` [m] to the stop, and whether the stop binds, also
    /// one that is `near` [m] nearer.
    pub(super) fn target(
        &self,
        planned: &Planned<'_, '_>,
        arc: f64,
        (y, near): (f64, f64),
        z: f64,
        dt: f64,
    ) -> (f64, f64, bool) {
        // The command holds for a period: in its middle.
        let half = 0.5 * dt * larger(z, 0.0);
        let here = planned.at(arc);
        let slope = planned.at(arc + half).slope;
        let along = larger(sqrt(here.squared), self.creep(&here));
        let (curve, _) = self.curve(y, dt);
        let (_, braking) = self.curve(y - half, dt);
        let (target, change) = if curve < along {
            (curve, -braking)
        } else {
            (along, slope)
        };
        let stops = curve < along || (near > 0.0 && self.curve(y - near, dt).0 < along);
        // dz*/ds z, which a vehicle that is slower than its plan does not brake by.
        let ratio = if change < 0.0 && target > 0.0 {
            saturate(z / target, 0.0, 2.0)
        } else {
            1.0
        };
        (target, change * ratio, stops)
    }

    /// The speed with which a vehicle creeps where its plan begins at rest [m/s]: never above the plan's.
    pub(super) fn creep(&self, plan: &PlanAt) -> f64 {
        smaller(CREEP * self.car.wheelbase, sqrt(plan.highest))
    }

    /// `T`: how long the end of a stop takes, in which the deceleration fades [s].
    pub(super) fn end_time(&self, dt: f64) -> f64 {
        let response = self.car.drive_delay + self.car.drive_lag + dt;
        larger(self.accelerations.1 / self.params.max_jerk, SOFT * response)
    }

    /// The speed from which the vehicle still stops within `y` [m], and its deceleration.
    pub(super) fn curve(&self, y: f64, dt: f64) -> (f64, f64) {
        let (braking, time) = (self.accelerations.1, self.end_time(dt));
        let (jerk, end) = (braking / time, braking * time * time / 6.0);
        if y <= 0.0 {
            (0.0, braking)
        } else if y < end {
            let t = powf(6.0 * y / jerk, 1.0 / 3.0);
            (0.5 * jerk * t * t, jerk * t)
        } else {
            let slow = 0.5 * braking * time;
            (sqrt(slow * slow + 2.0 * braking * (y - end)), braking)
        }
    }
}
