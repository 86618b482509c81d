//! The inputs of a batch at a step: arrays, copied and kept, to spare their allocation.

use numpy::ndarray::Zip;
use popsteer_core::VehicleState;
use popsteer_core::tracker::Reported;
use popsteer_sim::batch::OnError;
use pyo3::prelude::*;

use crate::arrays::column;
use crate::errors::unknown;
use crate::params::Count;

/// Poses and speeds of the vehicles, and what they report beside that.
#[derive(Clone, Debug, Default)]
pub(crate) struct Inputs {
    pub(crate) vehicles: Vec<VehicleState>,
    /// Empty where they report nothing.
    pub(crate) reported: Vec<Reported>,
}

impl Inputs {
    /// Copies the arrays: other threads may write to them while the lock is released.
    pub(crate) fn read(
        &mut self,
        count: usize,
        [x, y, yaw, speed]: [&Bound<'_, PyAny>; 4],
        steers: [Option<&Bound<'_, PyAny>>; 2],
        pose_age: &Ages<'_>,
    ) -> PyResult<()> {
        let (x, y) = (column(x, "x", count)?, column(y, "y", count)?);
        let (yaw, speed) = (column(yaw, "yaw", count)?, column(speed, "speed", count)?);
        self.vehicles.resize(count, VehicleState::ORIGIN);
        Zip::from(self.vehicles.as_mut_slice())
            .and(x.as_array())
            .and(y.as_array())
            .and(yaw.as_array())
            .and(speed.as_array())
            .for_each(|place, &x, &y, &yaw, &speed| *place = VehicleState { x, y, yaw, speed });
        self.read_reported(count, steers, pose_age)
    }

    /// Copies what the vehicles report beside pose and speed: applied and measured angles, ages.
    fn read_reported(
        &mut self,
        count: usize,
        steers: [Option<&Bound<'_, PyAny>>; 2],
        pose_age: &Ages<'_>,
    ) -> PyResult<()> {
        self.reported.clear();
        if let ([None, None], Ages::Same(age)) = (steers, pose_age)
            && age.to_bits() == 0
        {
            return Ok(());
        }
        self.reported.resize(count, Reported::NOTHING);
        let [applied, measured] = steers;
        if let Some(applied) = applied {
            let applied = column(applied, "applied_steer", count)?;
            for (report, &steer) in self.reported.iter_mut().zip(applied.as_array()) {
                report.applied_steer = Some(steer);
            }
        }
        if let Some(measured) = measured {
            let measured = column(measured, "measured_steer", count)?;
            for (report, &steer) in self.reported.iter_mut().zip(measured.as_array()) {
                report.measured_steer = Some(steer);
            }
        }
        match pose_age {
            Ages::Same(age) => {
                for report in &mut self.reported {
                    report.pose_age = *age;
                }
            }
            Ages::Each(ages) => {
                let ages = column(ages, "pose_age", count)?;
                for (report, &age) in self.reported.iter_mut().zip(ages.as_array()) {
                    report.pose_age = age;
                }
            }
        }
        Ok(())
    }
}

/// How old the poses are [s].
#[derive(Clone, Debug)]
pub(crate) enum Ages<'py> {
    /// All alike.
    Same(f64),
    /// An array, one entry a vehicle.
    Each(Bound<'py, PyAny>),
}

impl<'py> FromPyObject<'_, 'py> for Ages<'py> {
    type Error = PyErr;

    fn extract(object: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        match object.extract::<f64>() {
            Ok(age) => Ok(Self::Same(age)),
            Err(_) => Ok(Self::Each(object.to_owned())),
        }
    }
}

/// What is to be done about an input that is refused.
pub(crate) fn on_error_of(py: Python<'_>, on_error: &str, hold_limit: Count) -> PyResult<OnError> {
    match on_error {
        "raise" => Ok(OnError::Raise),
        "nan" => Ok(OnError::Mark),
        "hold" => Ok(OnError::Hold(hold_limit.saturated())),
        _ => Err(unknown(py, "on_error", on_error, &["raise", "nan", "hold"])),
    }
}
