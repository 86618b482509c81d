//! The metrics of a run.

use popsteer_core::Status;

use crate::record::Record;

/// Statistics of the absolute value of an error.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ErrorStats {
    /// Mean of the absolute values; NaN of none.
    pub mean_abs: f64,
    /// Root of the mean square; NaN of none.
    pub rms: f64,
    /// Largest absolute value; NaN of none.
    pub max_abs: f64,
}

/// Cross-track error [m] and heading error [rad] at one point of the vehicle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Errors<T = ErrorStats> {
    /// Cross-track error over the whole run [m].
    pub cross_track: T,
    /// Cross-track error after the settling time [m].
    pub settled_cross_track: T,
    /// Heading error over the whole run [rad].
    pub heading: T,
    /// Heading error after the settling time [rad].
    pub settled_heading: T,
}

/// The metrics of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Metrics {
    /// Errors at the controller's own reference point, as the paper measures.
    pub reference: Errors,
    /// Errors at the rear axle, one point for all controllers.
    pub rear_axle: Errors,
    /// Largest angle commanded [rad].
    pub max_abs_steer: f64,
    /// Root of the mean square of the steering rate commanded [rad/s].
    pub rms_steer_rate: f64,
    /// Mean speed, forward or backwards [m/s].
    pub mean_speed: f64,
    /// Time driven [s].
    pub time: f64,
    /// Control steps.
    pub steps: usize,
    /// Whether the end of the path was reached.
    pub finished: bool,
    /// The faults that the driver said in any of the steps.
    pub faults: Status,
}

#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct Accumulator {
    count: usize,
    sum: f64,
    squares: f64,
    max: f64,
}

impl Accumulator {
    fn push(&mut self, error: f64) {
        let error = error.abs();
        self.count += 1;
        self.sum += error;
        self.squares += error * error;
        self.max = self.max.max(error);
    }

    fn stats(&self) -> ErrorStats {
        let count = popsteer_core::math::from_count(self.count);
        ErrorStats {
            mean_abs: self.sum / count,
            rms: (self.squares / count).sqrt(),
            max_abs: if self.count == 0 { f64::NAN } else { self.max },
        }
    }
}

impl Errors<Accumulator> {
    fn push(&mut self, cross_track: f64, heading: f64, settled: bool) {
        self.cross_track.push(cross_track);
        self.heading.push(heading);
        if settled {
            self.settled_cross_track.push(cross_track);
            self.settled_heading.push(heading);
        }
    }

    fn errors(&self) -> Errors {
        Errors {
            cross_track: self.cross_track.stats(),
            settled_cross_track: self.settled_cross_track.stats(),
            heading: self.heading.stats(),
            settled_heading: self.settled_heading.stats(),
        }
    }
}

/// Metrics gathered step by step, without keeping the records.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Gatherer {
    reference: Errors<Accumulator>,
    rear_axle: Errors<Accumulator>,
    steer_rate: Accumulator,
    previous_steer: Option<f64>,
    max_abs_steer: f64,
    speed_sum: f64,
    steps: usize,
    #[cfg_attr(feature = "serde", serde(with = "crate::record::bits"))]
    faults: Status,
}

impl Gatherer {
    pub(crate) fn push(&mut self, record: &Record, settling_time: f64, dt: f64) {
        // Times are sums of dt; half a step keeps their rounding from moving the border.
        let settled = record.time >= settling_time - 0.5 * dt;
        self.reference
            .push(record.cross_track_error, record.heading_error, settled);
        self.rear_axle.push(
            record.rear_cross_track_error,
            record.rear_heading_error,
            settled,
        );
        if let Some(previous) = self.previous_steer {
            self.steer_rate.push((record.steer - previous) / dt);
        }
        self.previous_steer = Some(record.steer);
        self.max_abs_steer = self.max_abs_steer.max(record.steer.abs());
        self.speed_sum += record.speed.abs();
        self.steps += 1;
        self.faults |= record.status.faults();
    }

    pub(crate) fn metrics(&self, time: f64, finished: bool) -> Metrics {
        Metrics {
            reference: self.reference.errors(),
            rear_axle: self.rear_axle.errors(),
            max_abs_steer: self.max_abs_steer,
            rms_steer_rate: self.steer_rate.stats().rms,
            mean_speed: self.speed_sum / popsteer_core::math::from_count(self.steps),
            time,
            steps: self.steps,
            finished,
            faults: self.faults,
        }
    }
}
