//! Many vehicles, one step at a time, on all cores.

use std::sync::Arc;

use popsteer_core::lateral::TrackerState;
use popsteer_core::vehicle::state::checked_dt;
use popsteer_core::{Command, InputError, LateralLaw, Path, Tracker, VehicleState};
use rayon::prelude::*;

/// Vehicles a thread takes at a time: enough to outweigh handing them over. A batch of no more is
/// stepped on the thread that asks for it.
pub const CHUNK: usize = 256;

/// Vehicles under controllers of one kind, each with a vehicle, parameters, path and state of its
/// own.
#[derive(Clone, Debug)]
pub struct Batch<L: LateralLaw> {
    vehicles: Vec<Driver<L>>,
}

#[derive(Clone, Debug)]
struct Driver<L: LateralLaw> {
    law: Tracker<L>,
    path: Arc<Path>,
    state: TrackerState<L::State>,
}

/// A vehicle whose input is refused.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BatchError {
    /// Its place in the batch; none where `dt` is refused.
    pub vehicle: Option<usize>,
    /// Why.
    pub error: InputError,
}

impl<L> Batch<L>
where
    L: LateralLaw + Clone + Send + Sync,
    L::State: Send + Sync,
{
    /// One vehicle for each law and path, in its initial state.
    pub fn new(laws: impl IntoIterator<Item = (Tracker<L>, Arc<Path>)>) -> Self {
        Self::resume(laws.into_iter().map(|(law, path)| {
            let state = law.initial_state();
            (law, path, state)
        }))
    }

    /// One vehicle for each law, path and state; the state is one that [`Tracker::check_state`]
    /// accepts.
    pub fn resume(
        vehicles: impl IntoIterator<Item = (Tracker<L>, Arc<Path>, TrackerState<L::State>)>,
    ) -> Self {
        let drivers = vehicles
            .into_iter()
            .map(|(law, path, state)| Driver { law, path, state });
        Self {
            vehicles: drivers.collect(),
        }
    }

    /// How many vehicles.
    pub fn len(&self) -> usize {
        self.vehicles.len()
    }

    /// Whether there is no vehicle.
    pub fn is_empty(&self) -> bool {
        self.vehicles.is_empty()
    }

    /// Takes every vehicle back to its initial state.
    pub fn reset(&mut self) {
        for vehicle in &mut self.vehicles {
            vehicle.state = vehicle.law.initial_state();
        }
    }

    /// The states, in order.
    pub fn states(&self) -> impl ExactSizeIterator<Item = &TrackerState<L::State>> {
        self.vehicles.iter().map(|vehicle| &vehicle.state)
    }

    /// Steps every vehicle: `write` is given each place in `out`, and what [`Tracker::step`]
    /// of that vehicle's law answers to its input.
    ///
    /// # Errors
    ///
    /// [`BatchError`] for the first vehicle whose input is refused, unless `skip_refused`; no
    /// vehicle has moved then. With `skip_refused` such a vehicle keeps its state, `write` is
    /// given its error, and the others go on. A bad `dt` is refused in any case.
    ///
    /// # Panics
    ///
    /// Where `inputs` or `out` is not as long as the batch.
    pub fn step<T: Send>(
        &mut self,
        inputs: &[VehicleState],
        dt: f64,
        skip_refused: bool,
        out: &mut [T],
        write: impl Fn(&mut T, Result<Command, InputError>) + Sync,
    ) -> Result<(), BatchError> {
        self.drive(inputs, dt, skip_refused, out, |driver, input, place| {
            let path = driver.path.view();
            write(place, driver.law.step(&path, &mut driver.state, input, dt));
        })
    }

    /// Steps every vehicle for the angle alone, as [`step`](Self::step).
    ///
    /// # Errors
    ///
    /// As [`step`](Self::step); a vehicle refused under `skip_refused` is given NaN.
    ///
    /// # Panics
    ///
    /// As [`step`](Self::step).
    pub fn steer(
        &mut self,
        inputs: &[VehicleState],
        dt: f64,
        skip_refused: bool,
        out: &mut [f64],
    ) -> Result<(), BatchError> {
        self.drive(inputs, dt, skip_refused, out, |driver, input, angle| {
            let path = driver.path.view();
            let steered = driver.law.steer(&path, &mut driver.state, input, dt);
            *angle = steered.unwrap_or(f64::NAN);
        })
    }

    fn drive<T: Send>(
        &mut self,
        inputs: &[VehicleState],
        dt: f64,
        skip_refused: bool,
        out: &mut [T],
        one: impl Fn(&mut Driver<L>, VehicleState, &mut T) + Sync,
    ) -> Result<(), BatchError> {
        assert_eq!(inputs.len(), self.len(), "one input for each vehicle");
        assert_eq!(out.len(), self.len(), "one place for each vehicle");
        checked_dt(dt).map_err(|error| BatchError {
            vehicle: None,
            error,
        })?;
        if !skip_refused {
            let refused = inputs.iter().enumerate().find_map(|(vehicle, input)| {
                let error = input.checked().err()?;
                Some(BatchError {
                    vehicle: Some(vehicle),
                    error,
                })
            });
            refused.map_or(Ok(()), Err)?;
        }
        if self.len() <= CHUNK {
            for ((driver, &input), place) in self.vehicles.iter_mut().zip(inputs).zip(out) {
                one(driver, input, place);
            }
            return Ok(());
        }
        self.vehicles
            .par_iter_mut()
            .zip(inputs.par_iter())
            .zip(out.par_iter_mut())
            .with_min_len(CHUNK)
            .for_each(|((driver, &input), place)| one(driver, input, place));
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use popsteer_core::Vehicle;
    use popsteer_core::lateral::{Pop, PopParams};

    fn batch(count: usize) -> (Batch<Pop>, Tracker<Pop>, Arc<Path>) {
        let x: Vec<f64> = (0..300).map(f64::from).collect();
        let y: Vec<f64> = x.iter().map(|x| 5.0 * (x / 20.0).sin()).collect();
        let path = Arc::new(Path::new(&x, &y, None, false).unwrap());
        let law = Tracker::of(Pop::new(Vehicle::PAPER, PopParams::default()).unwrap());
        (
            Batch::new((0..count).map(|_| (law, Arc::clone(&path)))),
            law,
            path,
        )
    }

    fn inputs(count: u32) -> Vec<VehicleState> {
        let vehicle = |k| VehicleState {
            x: f64::from(k % 250),
            y: f64::from(k % 7) - 3.0,
            yaw: 0.01 * f64::from(k % 40),
            speed: f64::from(k % 20),
        };
        (0..count).map(vehicle).collect()
    }

    #[test]
    fn test_batch_steps_are_single_steps_bit_for_bit() {
        let (mut batch, law, path) = batch(2000);
        let inputs = inputs(2000);
        let mut angles = vec![0.0; 2000];
        let mut states: Vec<_> = (0..2000).map(|_| law.initial_state()).collect();
        for _ in 0..5 {
            batch.steer(&inputs, 0.05, false, &mut angles).unwrap();
            for ((state, &input), angle) in states.iter_mut().zip(&inputs).zip(&angles) {
                let single = law.steer(&path.view(), state, input, 0.05).unwrap();
                assert_eq!(single.to_bits(), angle.to_bits());
            }
        }
        assert!(batch.states().eq(states.iter()));
    }

    #[test]
    fn test_batch_one_bad_vehicle_refuses_all_or_is_marked() {
        let (mut batch, ..) = batch(5);
        let mut inputs = inputs(5);
        inputs[3].speed = f64::NAN;
        let mut angles = vec![0.0; 5];
        let before: Vec<_> = batch.states().copied().collect();
        let refused = batch.steer(&inputs, 0.05, false, &mut angles).unwrap_err();
        assert_eq!((refused.vehicle, refused.error.field), (Some(3), "speed"));
        assert!(batch.states().eq(before.iter()));
        batch.steer(&inputs, 0.05, true, &mut angles).unwrap();
        let nan: Vec<bool> = angles.iter().map(|angle| angle.is_nan()).collect();
        assert_eq!(nan, [false, false, false, true, false]);
        assert!(batch.steer(&inputs, -1.0, true, &mut angles).is_err());
    }
}
