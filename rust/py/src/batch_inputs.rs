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
        [pose_age, roll]: [&Each<'_>; 2],
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
        self.read_reported(count, steers, [pose_age, roll])
    }

    /// Copies what the vehicles report beside pose and speed: applied and measured angles, ages, rolls.
    fn read_reported(
        &mut self,
        count: usize,
        steers: [Option<&Bound<'_, PyAny>>; 2],
        [pose_age, roll]: [&Each<'_>; 2],
    ) -> PyResult<()> {
        self.reported.clear();
        if let ([None, None], true) = (steers, pose_age.is_zero() && roll.is_zero()) {
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
        pose_age.write(&mut self.reported, "pose_age", |it| &mut it.pose_age)?;
        roll.write(&mut self.reported, "roll", |it| &mut it.roll)?;
        Ok(())
    }
}

/// A number of each vehicle.
#[derive(Clone, Debug)]
pub(crate) enum Each<'py> {
    /// All alike.
    Same(f64),
    /// An array, one entry a vehicle.
    Array(Bound<'py, PyAny>),
}

impl Each<'_> {
    fn is_zero(&self) -> bool {
        matches!(self, Self::Same(value) if value.to_bits() == 0)
    }

    /// Writes them into a `field` of what each vehicle reports; `name` is the argument's.
    fn write(
        &self,
        reported: &mut [Reported],
        name: &str,
        field: impl Fn(&mut Reported) -> &mut f64,
    ) -> PyResult<()> {
        match self {
            Self::Same(value) => {
                for report in reported {
                    *field(report) = *value;
                }
            }
            Self::Array(values) => {
                let values = column(values, name, reported.len())?;
                for (report, &value) in reported.iter_mut().zip(values.as_array()) {
                    *field(report) = value;
                }
            }
        }
        Ok(())
    }
}

impl<'py> FromPyObject<'_, 'py> for Each<'py> {
    type Error = PyErr;

    fn extract(object: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        match object.extract::<f64>() {
            Ok(value) => Ok(Self::Same(value)),
            Err(_) => Ok(Self::Array(object.to_owned())),
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
