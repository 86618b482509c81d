//! A law as a vehicle takes it: the actuator around it, the hand-over from a driver, and an answer
//! to every input.

use alloc::boxed::Box;

use super::{Command, LateralLaw, LateralState, Status};
use crate::Point;
use crate::error::{InputError, Requirement, input_in_range};
use crate::math::saturate;
use crate::path::follow::Follow;
use crate::path::view::PathView;
use crate::vehicle::state::checked_dt;
use crate::vehicle::{Actuator, Learnt, UnderWay, VehicleState};

/// How long the difference to a driver's angle takes to fade [s].
pub const HANDOVER_TIME: f64 = 1.0;

/// A law, and the actuator that its commands go through.
///
/// With an actuator the law is shown the vehicle as it will be when its command arrives, and the
/// errors of its [`Command`] are those of that vehicle; commands keep the actuator's rate. A law
/// that starts from a driver's angle, or on another path, goes on from the present angle: the
/// difference to what the law itself wants fades evenly over [`HANDOVER_TIME`]; POP, whose next
/// angle lies in the neighbourhood of the last, needs no fading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tracker<L> {
    law: L,
    actuator: Option<Actuator>,
}

/// The difference to the angle that a law took over [rad], and how long it fades on [s].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Handover {
    /// None before the first step.
    pub offset: Option<f64>,
    /// From [`HANDOVER_TIME`] to 0.
    pub left: f64,
}

/// What a [`Tracker`] remembers.
#[derive(Clone, Debug, PartialEq)]
pub struct TrackerState<S> {
    /// What the law remembers.
    pub law: S,
    /// The angle last commanded [rad].
    pub steer: f64,
    /// A hand-over that is not over.
    pub handover: Option<Handover>,
    /// How many inputs in a row were refused.
    pub held: usize,
    /// Commands on their way through the actuator, where there is one.
    pub under_way: Option<Box<UnderWay>>,
}

impl<S: LateralState> LateralState for TrackerState<S> {
    fn set_waypoint(&mut self, waypoint: Option<usize>) {
        self.law.set_waypoint(waypoint);
    }

    /// The next answer goes on from the present angle.
    fn leave_path(&mut self) {
        self.law.leave_path();
        self.take_over(self.steer);
    }

    fn set_steer(&mut self, steer: f64) -> bool {
        self.take_over(steer);
        true
    }
}

impl<S: LateralState> TrackerState<S> {
    fn take_over(&mut self, steer: f64) {
        self.steer = steer;
        self.handover = if self.law.set_steer(steer) {
            None
        } else {
            Some(Handover {
                offset: None,
                left: HANDOVER_TIME,
            })
        };
    }
}

impl<L: LateralLaw> Tracker<L> {
    /// `law` behind `actuator`; without one its commands reach the wheels as they are.
    pub const fn new(law: L, actuator: Option<Actuator>) -> Self {
        Self { law, actuator }
    }

    /// The law.
    pub fn law(&self) -> &L {
        &self.law
    }

    /// The actuator, where there is one.
    pub fn actuator(&self) -> Option<&Actuator> {
        self.actuator.as_ref()
    }

    /// The same with the law made into another by `change`.
    pub fn map<M: LateralLaw>(self, change: impl FnOnce(L) -> M) -> Tracker<M> {
        Tracker::new(change(self.law), self.actuator)
    }

    /// The state before the first step of a vehicle whose wheels stand at the angle `steer` [rad],
    /// which a driver leaves to the law.
    ///
    /// # Errors
    ///
    /// [`InputError`] where `steer` is not within `max_steer`.
    pub fn state_from(&self, steer: f64) -> Result<TrackerState<L::State>, InputError> {
        super::check_steer("steer", steer, self.law.max_steer())?;
        let mut state = self.initial_state();
        state.take_over(steer);
        state.under_way = self
            .actuator
            .map(|actuator| Box::new(actuator.settled(steer)));
        Ok(state)
    }

    /// A step that answers whatever comes in: where [`step`](LateralLaw::step) refuses the input,
    /// the last angle is held, with the status [`Status::InputHeld`] for up to `hold_limit` inputs
    /// in a row and [`Status::InputLost`] beyond. The errors and the target of such a command are
    /// 0; the law's state stays.
    pub fn step_or_hold(
        &self,
        path: &PathView<'_>,
        state: &mut TrackerState<L::State>,
        vehicle: VehicleState,
        dt: f64,
        hold_limit: usize,
    ) -> Command {
        if let Ok(command) = self.step(path, state, vehicle, dt) {
            return command;
        }
        state.held = state.held.saturating_add(1);
        if let (Some(actuator), Some(under_way)) = (&self.actuator, &mut state.under_way) {
            // The angle that is held goes on its way like any other.
            if let Ok(dt) = checked_dt(dt) {
                actuator.elapse(under_way, state.steer, dt);
            }
            under_way.lose_sight();
        }
        Command {
            steer: state.steer,
            cross_track_error: 0.0,
            heading_error: 0.0,
            target: Point::new(0.0, 0.0),
            reverse: false,
            status: if state.held > hold_limit {
                Status::InputLost
            } else {
                Status::InputHeld
            },
        }
    }

    /// The vehicle as the law is to see it, and what its way since the last step teaches.
    #[inline]
    fn seen(
        &self,
        state: &TrackerState<L::State>,
        vehicle: VehicleState,
        dt: f64,
    ) -> Result<(VehicleState, Learnt), InputError> {
        match (&self.actuator, &state.under_way) {
            (Some(actuator), Some(under_way)) => {
                let (vehicle, dt) = (vehicle.checked()?, checked_dt(dt)?);
                let learnt = actuator.learn(under_way, state.steer, vehicle, dt);
                let seen = actuator.predict(under_way, state.steer, vehicle, dt, &learnt);
                // What was given is good, so what comes of it is not refused.
                Ok((seen.bounded(), learnt))
            }
            _ => Ok((vehicle, Learnt::default())),
        }
    }

    /// The angle to command where the law wants `wanted`, and whether it is a limited one.
    #[inline]
    fn give(
        &self,
        state: &mut TrackerState<L::State>,
        wanted: f64,
        dt: f64,
        learnt: Learnt,
    ) -> (f64, bool) {
        state.held = 0;
        if self.actuator.is_none() && state.handover.is_none() {
            state.steer = wanted;
            return (wanted, false);
        }
        self.give_limited(state, wanted, dt, learnt)
    }

    fn give_limited(
        &self,
        state: &mut TrackerState<L::State>,
        wanted: f64,
        dt: f64,
        learnt: Learnt,
    ) -> (f64, bool) {
        let faded = match &mut state.handover {
            None => wanted,
            Some(handover) => {
                let offset = match handover.offset {
                    None => state.steer - wanted,
                    Some(offset) => {
                        handover.left -= dt;
                        offset
                    }
                };
                handover.offset = Some(offset);
                let share = saturate(handover.left / HANDOVER_TIME, 0.0, 1.0);
                if handover.left <= 0.0 {
                    state.handover = None;
                }
                wanted + share * offset
            }
        };
        let max_steer = self.law.max_steer();
        let faded = saturate(faded, -max_steer, max_steer);
        let last = state.steer;
        let steer = match (&self.actuator, &mut state.under_way) {
            (Some(actuator), Some(under_way)) => {
                actuator.elapse_learning(under_way, last, dt, learnt);
                actuator.limit(last, faded, dt)
            }
            _ => faded,
        };
        state.law.set_steer(steer);
        state.steer = steer;
        let limited = steer.total_cmp(&faded).is_ne();
        (steer, limited)
    }
}

impl<L: LateralLaw> LateralLaw for Tracker<L> {
    type State = TrackerState<L::State>;

    fn initial_state(&self) -> Self::State {
        TrackerState {
            law: self.law.initial_state(),
            steer: 0.0,
            handover: None,
            held: 0,
            under_way: self
                .actuator
                .map(|actuator| Box::new(actuator.settled(0.0))),
        }
    }

    fn follow(&self) -> &Follow {
        self.law.follow()
    }

    fn max_steer(&self) -> f64 {
        self.law.max_steer()
    }

    #[inline]
    fn step(
        &self,
        path: &PathView<'_>,
        state: &mut Self::State,
        vehicle: VehicleState,
        dt: f64,
    ) -> Result<Command, InputError> {
        let (seen, learnt) = self.seen(state, vehicle, dt)?;
        let command = self.law.step(path, &mut state.law, seen, dt)?;
        let (steer, limited) = self.give(state, command.steer, dt, learnt);
        let status = if limited && command.status == Status::Ok {
            Status::Saturated
        } else {
            command.status
        };
        Ok(Command {
            steer,
            status,
            ..command
        })
    }

    #[inline]
    fn steer(
        &self,
        path: &PathView<'_>,
        state: &mut Self::State,
        vehicle: VehicleState,
        dt: f64,
    ) -> Result<f64, InputError> {
        let (seen, learnt) = self.seen(state, vehicle, dt)?;
        let wanted = self.law.steer(path, &mut state.law, seen, dt)?;
        Ok(self.give(state, wanted, dt, learnt).0)
    }

    fn check_state(&self, path: &PathView<'_>, state: &Self::State) -> Result<(), InputError> {
        self.law.check_state(path, &state.law)?;
        super::check_steer("steer", state.steer, self.law.max_steer())?;
        if let Some(Handover { offset, left }) = state.handover {
            let widest = 2.0 * self.law.max_steer();
            super::check_steer("handover_offset", offset.unwrap_or(0.0), widest)?;
            input_in_range("handover_left", left, 0.0, HANDOVER_TIME)?;
        }
        match (&self.actuator, &state.under_way) {
            (None, _) => Ok(()),
            (Some(actuator), Some(under_way)) => actuator.check(under_way),
            // With nothing under way known, neither rate nor prediction could be kept.
            (Some(_), None) => Err(InputError {
                field: "under_way",
                value: 0.0,
                requirement: Requirement::CountInRange(1, UnderWay::CAPACITY),
            }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Path;
    use crate::lateral::{Pop, PopParams, Stanley, StanleyParams};
    use crate::vehicle::ActuatorParams;

    fn straight() -> Path {
        Path::new(&[0.0, 100.0], &[0.0, 0.0], None, false).unwrap()
    }

    fn beside() -> VehicleState {
        VehicleState {
            x: 5.0,
            y: 1.0,
            yaw: 0.1,
            speed: 5.0,
        }
    }

    fn stanley(actuator: Option<ActuatorParams>) -> Tracker<Stanley> {
        let law = Stanley::new(StanleyParams::DEFAULT).unwrap();
        Tracker::new(law, actuator.map(|params| Actuator::new(params).unwrap()))
    }

    #[test]
    fn test_tracker_bare_is_the_law() {
        let path = straight();
        let tracker = stanley(None);
        let mut state = tracker.initial_state();
        let mut bare = tracker.law().initial_state();
        for _ in 0..3 {
            assert_eq!(
                tracker.step(&path.view(), &mut state, beside(), 0.05),
                tracker.law().step(&path.view(), &mut bare, beside(), 0.05)
            );
        }
    }

    #[test]
    fn test_handover_starts_from_the_angle_and_fades() {
        let path = straight();
        let tracker = stanley(None);
        let mut bare = tracker.law().initial_state();
        let wanted = tracker
            .law()
            .steer(&path.view(), &mut bare, beside(), 0.1)
            .unwrap();
        let mut state = tracker.state_from(0.3).unwrap();
        let mut steer = || {
            tracker
                .steer(&path.view(), &mut state, beside(), 0.1)
                .unwrap()
        };
        assert!((steer() - 0.3).abs() < 1e-15);
        let mut before = 0.3;
        for _ in 0..9 {
            let next = steer();
            assert!((before - next - 0.1 * (0.3 - wanted)).abs() < 1e-12);
            before = next;
        }
        assert!((steer() - wanted).abs() < 1e-12);
        assert_eq!(steer(), wanted);
        assert_eq!(tracker.state_from(2.0).unwrap_err().field, "steer");
    }

    #[test]
    fn test_handover_pop_goes_on_from_the_angle() {
        let path = straight();
        let tracker = Tracker::new(Pop::new(PopParams::DEFAULT).unwrap(), None);
        let mut state = tracker.state_from(0.3).unwrap();
        let steer = tracker
            .steer(&path.view(), &mut state, beside(), 0.05)
            .unwrap();
        assert!((steer - 0.3).abs() <= PopParams::DEFAULT.steer_span + 1e-15);
    }

    #[test]
    fn test_rate_is_kept_and_said() {
        let path = straight();
        let tracker = stanley(Some(ActuatorParams {
            max_rate: Some(0.2),
            ..ActuatorParams::DEFAULT
        }));
        let mut state = tracker.initial_state();
        let command = tracker
            .step(&path.view(), &mut state, beside(), 0.05)
            .unwrap();
        assert_eq!(
            (command.steer, command.status),
            (-0.010_000_000_000_000_002, Status::Saturated)
        );
    }

    #[test]
    fn test_prediction_beyond_the_bounds_is_no_reason_to_refuse() {
        let path = straight();
        for learning_time in [0.0, 10.0] {
            let tracker = stanley(Some(ActuatorParams {
                dead_time: 10.0,
                learning_time,
                ..ActuatorParams::DEFAULT
            }));
            let mut state = tracker.state_from(1.0).unwrap();
            let yaw = crate::vehicle::state::MAX_YAW;
            // The faster of the speeds is taken for an acceleration that goes on.
            for (x, y, speed) in [(1e9, -1e9, 9e3), (-1e9, 1e9, 1e4), (1e9, 1e9, -1e4)] {
                let vehicle = VehicleState { x, y, yaw, speed };
                let command = tracker.step(&path.view(), &mut state, vehicle, 0.05);
                assert_eq!(command.unwrap().status, Status::OffPath);
                assert_eq!(tracker.check_state(&path.view(), &state), Ok(()));
            }
        }
    }

    #[test]
    fn test_check_state_refuses_what_is_under_way_through_another_actuator() {
        let path = straight();
        let dead = |dead_time| {
            stanley(Some(ActuatorParams {
                dead_time,
                ..ActuatorParams::DEFAULT
            }))
        };
        let check = |tracker: &Tracker<Stanley>, state| {
            let answer = tracker.check_state(&path.view(), &state);
            answer.map_err(|error| (error.field, error.value))
        };
        let state = dead(0.2).initial_state();
        assert_eq!(check(&dead(0.2), state.clone()), Ok(()));
        assert_eq!(check(&dead(0.3), state.clone()), Err(("under_way", 0.2)));
        assert_eq!(check(&stanley(None), state), Ok(()));
        let without = stanley(None).initial_state();
        assert_eq!(check(&dead(0.2), without), Err(("under_way", 0.0)));
    }

    #[test]
    fn test_input_refused_is_held_then_lost() {
        let path = straight();
        let tracker = stanley(None);
        let mut state = tracker.initial_state();
        let good = tracker
            .step(&path.view(), &mut state, beside(), 0.05)
            .unwrap();
        let bad = VehicleState {
            x: f64::NAN,
            ..beside()
        };
        let mut held = |vehicle| tracker.step_or_hold(&path.view(), &mut state, vehicle, 0.05, 2);
        for status in [Status::InputHeld, Status::InputHeld, Status::InputLost] {
            let command = held(bad);
            assert_eq!((command.steer, command.status), (good.steer, status));
        }
        assert_eq!(held(beside()), good);
        assert_eq!(held(bad).status, Status::InputHeld);
    }
}
