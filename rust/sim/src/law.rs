//! Any of the core's laws, chosen at run time.

use popsteer_core::lateral::{
    BangBang, BangBangState, Pid, PidState, Pop, PopState, PreviewPop, PreviewPopState,
    PurePursuit, PurePursuitState, Stanley, StanleyState,
};
use popsteer_core::path::Follow;
use popsteer_core::{Command, InputError, LateralLaw, LateralState, PathView, VehicleState};

macro_rules! laws {
    ($($law:ident($state:ident)),+ $(,)?) => {
        /// One of the laws.
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub enum Law {
            $(#[doc = concat!("[`", stringify!($law), "`].")] $law($law),)+
        }

        /// The state of one of the laws.
        // Moved once a run, not once a step: the size of the PID's buffer costs nothing here.
        #[expect(clippy::large_enum_variant, reason = "one state a run")]
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub enum LawState {
            $(#[doc = concat!("Of [`", stringify!($law), "`].")] $law($state),)+
        }

        impl LateralLaw for Law {
            type State = LawState;

            fn initial_state(&self) -> LawState {
                match self { $(Self::$law(law) => LawState::$law(law.initial_state()),)+ }
            }

            fn follow(&self) -> &Follow {
                match self { $(Self::$law(law) => law.follow(),)+ }
            }

            fn max_steer(&self) -> f64 {
                match self { $(Self::$law(law) => law.max_steer(),)+ }
            }

            /// A state of another law counts as none: the step starts from the initial one.
            fn step(
                &self,
                path: &PathView<'_>,
                state: &mut LawState,
                vehicle: VehicleState,
                dt: f64,
            ) -> Result<Command, InputError> {
                match (self, &mut *state) {
                    $((Self::$law(law), LawState::$law(state)) => {
                        law.step(path, state, vehicle, dt)
                    })+
                    _ => {
                        let mut initial = self.initial_state();
                        let command = self.step(path, &mut initial, vehicle, dt)?;
                        *state = initial;
                        Ok(command)
                    }
                }
            }

            fn check_state(&self, path: &PathView<'_>, state: &LawState) -> Result<(), InputError> {
                match (self, state) {
                    $((Self::$law(law), LawState::$law(state)) => law.check_state(path, state),)+
                    _ => Ok(()),
                }
            }
        }

        impl LateralState for LawState {
            fn set_waypoint(&mut self, waypoint: Option<usize>) {
                match self { $(Self::$law(state) => state.set_waypoint(waypoint),)+ }
            }

            fn leave_path(&mut self) {
                match self { $(Self::$law(state) => state.leave_path(),)+ }
            }

            fn set_steer(&mut self, steer: f64) -> bool {
                match self { $(Self::$law(state) => state.set_steer(steer),)+ }
            }
        }

        $(impl From<$law> for Law {
            fn from(law: $law) -> Self {
                Self::$law(law)
            }
        })+
    };
}

laws! {
    BangBang(BangBangState),
    Pid(PidState),
    PurePursuit(PurePursuitState),
    Stanley(StanleyState),
    Pop(PopState),
    PreviewPop(PreviewPopState),
}
