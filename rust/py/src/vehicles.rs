//! The vehicles of a batch.

use popsteer_core::laws::{Pid, Pop, PreviewPop, PurePursuit, Stanley};
use popsteer_sim::batch::{Batch, BatchError, CHUNK};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList, PyTuple, PyType};

use crate::errors::{Raises, entry_error};
use crate::laws::{PyPid, PyPop, PyPreviewPop, PyPurePursuit, PyStanley, all_laws};
use crate::pool;
use crate::tracker::state;

macro_rules! vehicles {
    ($($law:ident($class:ty, $params:ty)),+) => {
        /// The vehicles, of one controller each time: a batch of mixed ones would be as wide as the
        /// widest state.
        #[derive(Debug)]
        pub(crate) enum Vehicles {
            $($law(Batch<$law>),)+
        }
    };
}
all_laws!(vehicles);

/// What makes a controller anew, but for its state: its class and the arguments for it.
#[derive(Debug)]
pub(crate) struct Recipe {
    class: Py<PyType>,
    arguments: Py<PyTuple>,
    options: Py<PyDict>,
}

impl Recipe {
    /// A new controller, before its first step.
    pub(crate) fn make<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let class = self.class.bind(py);
        class.call(self.arguments.bind(py), Some(self.options.bind(py)))
    }
}

/// The same expression for the batch of any controller, whose name is `$name`.
macro_rules! each {
    ($vehicles:expr, $batch:ident $(named $name:ident)? => $body:expr) => {
        match $vehicles {
            Vehicles::Pop($batch) => { $(let $name = "Pop";)? $body }
            Vehicles::PreviewPop($batch) => { $(let $name = "PreviewPop";)? $body }
            Vehicles::Pid($batch) => { $(let $name = "Pid";)? $body }
            Vehicles::PurePursuit($batch) => { $(let $name = "PurePursuit";)? $body }
            Vehicles::Stanley($batch) => { $(let $name = "Stanley";)? $body }
        }
    };
}
pub(crate) use each;

impl Vehicles {
    /// `repeat` copies of each controller, and what makes each controller; all are of the class of
    /// the first.
    pub(crate) fn gather(
        controllers: &[Bound<'_, PyAny>],
        repeat: usize,
    ) -> PyResult<(Self, Vec<Recipe>)> {
        let Some(first) = controllers.first() else {
            return Ok((Self::Pop(Batch::new([])), Vec::new()));
        };
        macro_rules! try_each {
            ($($law:ident($class:ty, $params:ty)),+) => {$(
                if first.cast_exact::<$class>().is_ok() {
                    let mut batch = Batch::new([]);
                    let mut recipes = Vec::with_capacity(controllers.len());
                    for (index, controller) in controllers.iter().enumerate() {
                        let controller = controller.cast_exact::<$class>().map_err(|_| {
                            let wanted = concat!("of the first's class ", stringify!($law));
                            wrong_class(index, wanted, controller)
                        })?;
                        let class = controller.get_type().unbind();
                        let controller = controller.try_borrow()?;
                        batch.add(controller.member(), repeat);
                        let (arguments, options) = controller.__getnewargs_ex__(first.py())?;
                        let (arguments, options) = (arguments.unbind(), options.unbind());
                        recipes.push(Recipe { class, arguments, options });
                    }
                    return Ok((Self::$law(batch), recipes));
                }
            )+};
        }
        all_laws!(try_each);
        Err(wrong_class(0, "a controller of popsteer", first))
    }

    pub(crate) fn len(&self) -> usize {
        each!(self, batch => batch.len())
    }

    /// The states, in order.
    pub(crate) fn states<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyList>> {
        let states = PyList::empty(py);
        each!(self, batch named name => for state in batch.states() {
            states.append(state::shown(py, name, &state)?)?;
        });
        Ok(states)
    }

    /// Puts all states, in order, or none.
    pub(crate) fn set_states(&mut self, states: &Bound<'_, PyList>) -> Raises<()> {
        if states.len() != self.len() {
            let (given, wanted) = (states.len(), self.len());
            let words = format!("a batch of {wanted} vehicles has {wanted} states, got {given}");
            return Err(PyValueError::new_err(words).into());
        }
        each!(self, batch named name => {
            let mut restored = Vec::with_capacity(batch.len());
            for (member, state) in batch.members().zip(states) {
                let state = state::restored(name, &state)?;
                member.tracker.check_state(&member.path.view(), &state)?;
                restored.push(state);
            }
            batch.set_states(restored);
        });
        Ok(())
    }

    /// Does `work` on the vehicles without the interpreter's lock; `work` is given the vehicles.
    pub(crate) fn work(
        &mut self,
        py: Python<'_>,
        work: impl FnOnce(&mut Self) -> Result<(), BatchError> + Send,
    ) -> Raises<()> {
        let outcome = if self.len() <= CHUNK {
            py.detach(|| work(self))
        } else {
            let pool = pool::shared()?;
            py.detach(|| pool.install(|| work(self)))
        };
        outcome.map_err(|refused| match refused.vehicle {
            Some(vehicle) => entry_error(py, vehicle, refused.error).into(),
            None => refused.error.into(),
        })
    }
}

fn wrong_class(index: usize, wanted: &str, got: &Bound<'_, PyAny>) -> PyErr {
    let got = got.get_type();
    PyTypeError::new_err(format!("controllers[{index}] must be {wanted}, got {got}"))
}
