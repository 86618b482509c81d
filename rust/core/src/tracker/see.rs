//! The first half of a step: where the vehicle is believed to be, where on the path that is, and what
//! is wrong.

use crate::bounds::MIN_DT;
use crate::laws::{LateralLaw, LateralState};
use crate::math::larger;
use crate::path::{Follow, Located, PathView, Place};
use crate::status::Status;
use crate::tracker::monitor::Measured;
use crate::tracker::reported::Reported;
use crate::tracker::seen::Seen;
use crate::tracker::state::{Model, Tracking};
use crate::tracker::step::Tracker;
use crate::vehicle::gate::Gate;
use crate::vehicle::past::MAX_POSE_AGE;
use crate::vehicle::wheels::Reached;
use crate::vehicle::{Estimate, Motion, VehicleState};

impl<L: LateralLaw> Tracker<L> {
    /// The first half of a step: what time it is, where the vehicle is believed to be, and where on
    /// the path that is. Arguments as of [`advance`](Self::advance), checked, but for the pose, which is
    /// that of the vehicle's point wherever its antenna lies, and the expected one where none `comes`.
    /// `moved` says how the drive has moved a vehicle of this speed [m/s] since a pose of the age reported;
    /// None where no drive is known.
    ///
    /// What the vehicle is is learnt from one measured pose to the next: one that is expected, repeats or
    /// is an outlier shows nothing.
    #[inline]
    pub(crate) fn see(
        &self,
        path: &PathView<'_>,
        state: &mut Tracking<L::State>,
        model: &mut Model,
        vehicle: VehicleState,
        period: f64,
        (reported, comes, moved): (Reported, bool, impl FnOnce(f64) -> Option<Motion>),
    ) -> Seen {
        let dt = state.elapse(&mut model.estimator, period);
        if let Some(applied) = reported.applied_steer {
            // The command that was applied takes the place of the last one.
            state.steer = applied;
            state.law.set_steer(applied);
        }
        let age = reported.pose_age;
        let known = model.estimator.estimate;
        let (told, vehicle, signal) = self.hear(state, &known, vehicle, dt);
        let [lately, mut reached] = self.reach(state, model, dt, age);
        let (last, before) = state.speeds_before(vehicle.speed);
        let (vehicle, pose, jumped) = if comes {
            self.believe(state, model, vehicle, [&lately, &reached], age)
        } else {
            let pose = state.gate.as_mut().map(|gate| gate.wait(dt));
            (vehicle, pose.unwrap_or(Status::OK), false)
        };
        let doubted = state.gate.as_mut().is_some_and(|gate| gate.heard(signal));
        let told = if doubted {
            known.told(vehicle).speed
        } else {
            told
        };
        let expected = pose.contains(Status::OUTLIER) || pose.contains(Status::POSE_STALE);
        note_pose(model, &mut reached, age, comes && (jumped || !expected));
        let moved = (age > 0.0).then(|| moved(vehicle.speed)).flatten();
        let steered = (state.steer, dt, told);
        let perception = self.perceive(steered, model, vehicle, &reached, (reported, moved));
        let mut belief = perception.belief;

        let (here, predicted) = (perception.here, perception.predicted);
        // Since the last step it may have driven faster than now.
        let travelled = larger(here.speed.abs(), last.abs()) * dt;
        let follow = self.law.follow();
        let located = self.find(path, state, here, dt, travelled);
        if let Some(adapt) = self.adapt() {
            let estimator = &mut model.estimator;
            self.observe_slip(
                estimator,
                adapt,
                &located,
                (vehicle, told),
                &reached,
                &known,
            );
            belief.estimate = estimator.estimate;
        }
        let delays = self.models && belief.estimate.delays(self.law.vehicle());
        let moved = delays.then(|| follow.offset(path, &located, predicted, travelled));
        let fault = self.find_faults(state, model, &located, (vehicle, before), [lately, reached]);
        Seen {
            here,
            located,
            predicted: moved,
            belief,
            period,
            status: pose
                | fault
                | Status::END_OF_PATH.when(located.past_end)
                | Status::OFF_PATH.when(located.off_path),
        }
    }

    /// The speed as told, the vehicle with that which is believed of it, and what the signal says [m/s].
    #[inline]
    fn hear(
        &self,
        state: &mut Tracking<L::State>,
        known: &Estimate,
        vehicle: VehicleState,
        dt: f64,
    ) -> (f64, VehicleState, f64) {
        let signal = known.speed_of(vehicle.speed);
        let gate = state.gate.as_mut();
        let speed = gate.map_or(signal, |gate| gate.hear(self.law.vehicle(), signal, dt));
        let heard = VehicleState { speed, ..vehicle };
        let is_heard = (speed - signal).abs() <= 0.0;
        let told = if is_heard { vehicle } else { known.told(heard) };
        (told.speed, heard, signal)
    }

    /// Where the measured vehicle is: the tracker's place, moved on.
    #[inline]
    fn find(
        &self,
        path: &PathView<'_>,
        state: &Tracking<L::State>,
        vehicle: VehicleState,
        dt: f64,
        travelled: f64,
    ) -> Located {
        let follow = self.law.follow();
        if !self.parks || state.place == Place::Unknown {
            return follow.find(path, &state.place, vehicle, dt, travelled);
        }
        let follow = Follow {
            arrival_distance: f64::NEG_INFINITY,
            ..*follow
        };
        let mut at = follow.find(path, &state.place, vehicle, dt, travelled);
        let last = state.answer.as_ref();
        at.direction_changed = last.is_some_and(|last| last.reverse != at.reverse);
        at
    }

    /// The pose that the step goes on with, by the [`Gate`], and whether the localisation has jumped; the
    /// given one without a monitor, and where nothing of the vehicle is modelled. The wheels did what they
    /// reached since the last step and since the last measured pose.
    #[inline]
    fn believe(
        &self,
        state: &mut Tracking<L::State>,
        model: &mut Model,
        vehicle: VehicleState,
        [lately, reached]: [&Reached; 2],
        age: f64,
    ) -> (VehicleState, Status, bool) {
        if self.bare || self.monitor.is_none() {
            return (vehicle, Status::OK, false);
        }
        let car = self.law.vehicle();
        let Some(gate) = &mut state.gate else {
            state.gate = Some(Gate::new(vehicle, age));
            return (vehicle, Status::OK, false);
        };
        let is_last = age <= 0.0 && gate.age <= 0.0;
        let reached = if is_last { lately } else { reached };
        let bend = reached.bend(car, vehicle.speed, &model.estimator.estimate);
        let (status, jumped) = gate.pass(car, vehicle, bend, lately.time, age);
        let believed = gate.believed;
        if status == Status::OK {
            let speed = if gate.doubted {
                believed.speed
            } else {
                vehicle.speed
            };
            return (VehicleState { speed, ..vehicle }, status, false);
        }
        if jumped {
            model.estimator.last_measured = None;
            state.jump(state.place.lost());
        }
        (believed, status, jumped)
    }

    /// Compares the motion since the last measured pose with the commands, and returns the faults. It had
    /// the speed `before` [m/s].
    #[inline]
    fn find_faults(
        &self,
        state: &mut Tracking<L::State>,
        model: &Model,
        here: &Located,
        (vehicle, before): (VehicleState, f64),
        [lately, since]: [Reached; 2],
    ) -> Status {
        let Some(monitor) = &self.monitor else {
            return Status::OK;
        };
        let answer = state.answer.as_ref();
        let now = Measured {
            here,
            vehicle,
            last_speed: before,
            // Where wheels are modelled, a pose that shows nothing has none.
            reached: lately.wheels.map(|_| since),
            estimator: self.adapt().map(|_| &model.estimator),
            aside: state
                .gate
                .and_then(|gate| gate.position.last)
                .unwrap_or(0.0),
            noise: Gate::noise_of(state.gate.as_ref()).0,
            dt: lately.time,
        };
        let last_error = answer.map(|answer| answer.measured.cross_track_error);
        let (car, remembered) = (self.law.vehicle(), &mut state.monitor);
        monitor.check(car, remembered, state.steer, last_error, &now)
    }
}

/// Notes whether a pose of `age` [s] was `measured`, since the last of which the wheels did what they `reached`.
#[inline]
fn note_pose(model: &mut Model, reached: &mut Reached, age: f64, measured: bool) {
    if !measured {
        if model.past.is_none() && model.in_flight.is_some() && reached.wheels.is_some() {
            model.estimator.unseen = Some(*reached);
        }
        reached.wheels = None;
        return;
    }
    if let Some(past) = &mut model.past
        && past.since() - age >= MIN_DT
    {
        past.see(age);
    }
    if reached.time > MAX_POSE_AGE {
        // Longer than what the wheels did is remembered.
        model.estimator.last_measured = None;
    }
}
