//! The class of a state: the controller's own fields, and those that all controllers have.

/// A frozen class that shows a state of the core field by field.
///
/// Each field has a name, a type, a default in brackets, what it is and its text; those of the
/// [`Tail`](super::tail::Tail) have their places in it.
macro_rules! state {
    (
        $(#[doc = $about:literal])+
        $class:ident named $name:literal,
        $($own:tt)*
    ) => {
        state_class! {
            $(#[doc = $about])+
            $class named $name,
            own { $($own)* }
            tail {
                waypoint: Option<Count> = [None] at [waypoint], "int, optional",
                    "The segment of the last projection, that of the predicted vehicle; None before the first step.";
                measured_waypoint: Option<Count> = [None] at [measured_waypoint], "int, optional",
                    "The segment of the last projection of the measured vehicle; None without a dead time.";
                place: Option<Motion> = [None] at [place], "tuple of float, optional",
                    "The last projections: x, y [m] of the predicted vehicle's, x, y [m] of the measured one's; None before the first step and after a jump.";
                steer: f64 = [0.0] at [steer], "float, default 0.0",
                    "The angle last commanded [rad].";
                handover_offset: Option<f64> = [None] at [handover_offset], "float, optional",
                    "Difference to the angle that was taken over [rad]; None before the first step.";
                handover_remaining: f64 = [0.0] at [handover_remaining], "float, default 0.0",
                    "Remaining time of its fading [s]; 0 without a hand-over.";
                held: Count = [Count(0)] at [held], "int, default 0",
                    "How many inputs in a row were refused.";
                held_time: f64 = [0.0] at [held_time], "float, default 0.0",
                    "How much time the refused inputs took, which the next step counts [s].";
                period: f64 = [0.0] at [period], "float, default 0.0",
                    "The time that the last step counted [s]; 0 before the first.";
                wheel: Option<f64> = [None] at [wheel], "float, optional",
                    "Angle of the wheels by the vehicle's parameters [rad]; None where they are not modelled.";
                commands_in_flight: Row<(f64, f64)> = [Row(Vec::new())] at [commands_in_flight], "tuple of tuple of float, default ()",
                    "Commands that have not reached the wheels, oldest first: angle [rad] and duration [s].";
                past_angles: Row<(f64, f64)> = [Row(Vec::new())] at [past_angles], "tuple of tuple of float, default ()",
                    "Recent mean angles of the wheels, oldest first: angle [rad] and duration [s].";
                past_wheel: Option<f64> = [None] at [past_wheel], "float, optional",
                    "Angle that they end with [rad]; None before the first pose that had an age.";
                past_since: f64 = [0.0] at [past_since], "float, default 0.0",
                    "How long ago the last pose was measured [s].";
                last_measured: Option<Motion> = [None] at [last_measured], "tuple of float, optional",
                    "Where the no-slip point was last last_measured: x, y [m], yaw [rad] and speed [m/s].";
                turn_turn: f64 = [0.0] at [estimator.turn_turn], "float, default 0.0",
                    "Turns expected, squared [rad^2].";
                turn_offset: f64 = [0.0] at [estimator.turn_offset], "float, default 0.0",
                    "Turns expected times those of a radian of steering offset [rad].";
                offset_offset: f64 = [0.0] at [estimator.offset_offset], "float, default 0.0",
                    "Turns of a radian of steering offset, squared.";
                turn_measured: f64 = [0.0] at [estimator.turn_measured], "float, default 0.0",
                    "Turns expected times those measured [rad^2].";
                offset_measured: f64 = [0.0] at [estimator.offset_measured], "float, default 0.0",
                    "Turns of a radian of steering offset times those measured [rad].";
                turn: f64 = [0.0] at [estimator.turn], "float, default 0.0",
                    "The turn expected for the last period [rad].";
                change: f64 = [0.0] at [estimator.change], "float, default 0.0",
                    "Rates at which the expected turns changed, squared [rad^2/s^2].";
                gain: f64 = [1.0] at [estimator.estimate.gain], "float, default 1.0",
                    "Ratio of the measured turning to that of the given vehicle.";
                steer_offset: f64 = [0.0] at [estimator.estimate.steer_offset], "float, default 0.0",
                    "Estimated steering offset, in addition to the given one [rad].";
                longer_dead_time: f64 = [0.0] at [estimator.estimate.longer_dead_time], "float, default 0.0",
                    "Estimated dead time, in addition to the given one [s].";
                slip: f64 = [0.0] at [estimator.estimate.slip], "float, default 0.0",
                    "Angle of the motion of the no-slip point to the heading, straight on [rad].";
                slip_length: f64 = [0.0] at [estimator.estimate.slip_length], "float, default 0.0",
                    "How much that angle grows with the curvature [m].";
                acceleration: f64 = [0.0] at [estimator.estimate.acceleration], "float, default 0.0",
                    "Acceleration [m/s^2].";
                answer: Option<Answered> = [None] at [answer], "tuple, optional",
                    "What the last step answered, for as long as an input is held: cross-track error [m], yaw [rad] and the vector (x, y) along the path [m] of the measured vehicle, the same of the predicted one, the target (x, y) [m], whether it drove backwards, reference speed [m/s] and distance to stop [m], and where the vehicle was: x, y [m], yaw [rad] and speed [m/s].";
                monitor: Option<MonitorMemory> = [None] at [monitor], "tuple, optional",
                    "The monitor's state; None before the first step: (angle of the wheels [rad], yaw last measured [rad] or None, its residual [rad] or None), the turns of the last second ([rad]: measured, expected, of a slower response; its rate [rad/s]; of a radian of steering offset; excess of large angles [rad]), (time [s] and variance [rad^2] of the noise, sums of the offset [1/s], [rad/s]), how long it goes on being implausible [s], and whether it was within the limit of the deviation.";
            }
        }
    };
}
pub(super) use state;

/// The class itself, from the tables of its fields.
macro_rules! state_class {
    (
        $(#[doc = $about:literal])+
        $class:ident named $name:literal,
        own {
            $($field:ident: $kind:ty = [$($default:tt)+], $words:literal, $text:literal;)*
        }
        tail {
            $(
                $shared:ident: $shared_kind:ty = [$($shared_default:tt)+] at [$($place:tt)+],
                $shared_words:literal, $shared_text:literal;
            )+
        }
    ) => {
        $(#[doc = $about])+
        ///
        /// Parameters
        /// ----------
        $(
            #[doc = concat!(stringify!($field), " : ", $words)]
            #[doc = concat!("    ", $text)]
        )*
        $(
            #[doc = concat!(stringify!($shared), " : ", $shared_words)]
            #[doc = concat!("    ", $shared_text)]
        )+
        #[pyclass(frozen, eq, name = $name, module = "popsteer")]
        #[derive(Clone, Debug, PartialEq)]
        pub(crate) struct $class {
            $($field: $kind,)*
            tail: Tail,
        }

        #[pymethods]
        impl $class {
            #[new]
            #[pyo3(signature = (
                *, $($field = $($default)+,)* $($shared = $($shared_default)+),+
            ))]
            fn new($($field: $kind,)* $($shared: $shared_kind),+) -> Self {
                let mut tail = Tail::default();
                $(tail.$($place)+ = $shared;)+
                Self { $($field,)* tail }
            }

            $(
                #[doc = $text]
                #[getter]
                fn $field(&self) -> $kind {
                    self.$field.clone()
                }
            )*

            $(
                #[doc = $shared_text]
                #[getter]
                fn $shared(&self) -> $shared_kind {
                    self.tail.$($place)+.clone()
                }
            )+

            /// The fields by name, as a new ``dict``.
            fn as_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
                let fields = PyDict::new(py);
                $(fields.set_item(stringify!($field), self.$field())?;)*
                $(fields.set_item(stringify!($shared), self.$shared())?;)+
                Ok(fields)
            }

            fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
                repr($name, &self.as_dict(py)?)
            }

            fn __getnewargs_ex__<'py>(&self, py: Python<'py>) -> PyResult<NewArgs<'py>> {
                Ok((pyo3::types::PyTuple::empty(py), self.as_dict(py)?))
            }
        }
    };
}
pub(super) use state_class;
