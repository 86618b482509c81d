//! Any of the controllers, chosen at run time.

use super::{
    Belief, Decision, LateralLaw, LateralState, Pid, PidState, Pop, PopState, PreviewPop,
    PreviewPopState, PurePursuit, PurePursuitState, Stanley, StanleyState, Steered,
};
use crate::error::InputError;
use crate::path::{Located, PathView};

macro_rules! laws {
    ($($law:ident($state:ident)),+ $(,)?) => {
        /// One of the controllers.
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub enum Law {
            $(#[doc = concat!("[`", stringify!($law), "`].")] $law($law),)+
        }

        /// The state of one of the controllers.
        // Moved once a run, not once a step: the size of the PID's buffer costs nothing here.
        #[expect(clippy::large_enum_variant, reason = "one state a run")]
        #[derive(Clone, Copy, Debug, PartialEq)]
        #[cfg_attr(feature = "serde", derive(serde::Serialize), serde(untagged))]
        pub enum LawState {
            $(#[doc = concat!("Of [`", stringify!($law), "`].")] $law($state),)+
        }

        impl LateralLaw for Law {
            type State = LawState;

            fn initial_state(&self) -> LawState {
                match self { $(Self::$law(law) => LawState::$law(law.initial_state()),)+ }
            }

            fn steered(&self) -> &Steered {
                match self { $(Self::$law(law) => law.steered(),)+ }
            }

            fn reads_belief(&self) -> bool {
                match self { $(Self::$law(law) => law.reads_belief(),)+ }
            }

            fn pull(&self, at: &Located) -> f64 {
                match self { $(Self::$law(law) => law.pull(at),)+ }
            }

            /// A state of another controller counts as none: the step starts from the initial one.
            fn decide(
                &self,
                path: &PathView<'_>,
                state: &mut LawState,
                at: &Located,
                belief: &Belief,
            ) -> Decision {
                match (self, &mut *state) {
                    $((Self::$law(law), LawState::$law(state)) => {
                        law.decide(path, state, at, belief)
                    })+
                    _ => {
                        *state = self.initial_state();
                        self.decide(path, state, at, belief)
                    }
                }
            }

            fn check_state(&self, state: &LawState) -> Result<(), InputError> {
                match (self, state) {
                    $((Self::$law(law), LawState::$law(state)) => law.check_state(state),)+
                    _ => Ok(()),
                }
            }
        }

        impl LateralState for LawState {
            fn leave_path(&mut self) {
                match self { $(Self::$law(state) => state.leave_path(),)+ }
            }

            fn interrupt(&mut self) {
                match self { $(Self::$law(state) => state.interrupt(),)+ }
            }

            fn change_path(&mut self, offset: Option<f64>) {
                match self { $(Self::$law(state) => state.change_path(offset),)+ }
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
    Pid(PidState),
    PurePursuit(PurePursuitState),
    Stanley(StanleyState),
    Pop(PopState),
    PreviewPop(PreviewPopState),
}
