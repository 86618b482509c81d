//! The vehicles of a batch.

use popsteer_core::lateral::{BangBang, Pid, Pop, PreviewPop, PurePursuit, Stanley, Tracker};
use popsteer_sim::batch::{Batch, BatchError, CHUNK};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyList;

use crate::errors::{IntoPyErr, entry_error};
use crate::lateral::{
    PyBangBang, PyBangBangState, PyPid, PyPidState, PyPop, PyPopState, PyPreviewPop,
    PyPreviewPopState, PyPurePursuit, PyPurePursuitState, PyStanley, PyStanleyState, StateClass,
};
use crate::pool;

/// The vehicles, of one law each time: a batch of mixed ones would be as wide as the widest state.
#[derive(Debug)]
pub(crate) enum Vehicles {
    Pop(Batch<Tracker<Pop>>),
    PreviewPop(Batch<Tracker<PreviewPop>>),
    Pid(Batch<Tracker<Pid>>),
    PurePursuit(Batch<Tracker<PurePursuit>>),
    Stanley(Batch<Tracker<Stanley>>),
    BangBang(Batch<Tracker<BangBang>>),
}

/// The same expression for the batch of any law.
macro_rules! each {
    ($vehicles:expr, $batch:ident => $body:expr) => {
        match $vehicles {
            $crate::vehicles::Vehicles::Pop($batch) => $body,
            $crate::vehicles::Vehicles::PreviewPop($batch) => $body,
            $crate::vehicles::Vehicles::Pid($batch) => $body,
            $crate::vehicles::Vehicles::PurePursuit($batch) => $body,
            $crate::vehicles::Vehicles::Stanley($batch) => $body,
            $crate::vehicles::Vehicles::BangBang($batch) => $body,
        }
    };
}
pub(crate) use each;

impl Vehicles {
    /// `repeat` copies of each controller; all are of the class of the first.
    pub(crate) fn gather(controllers: &[Bound<'_, PyAny>], repeat: usize) -> PyResult<Self> {
        let Some(first) = controllers.first() else {
            return Ok(Self::Pop(Batch::new([])));
        };
        macro_rules! try_each {
            ($($law:ident($class:ty)),+) => {$(
                if first.cast_exact::<$class>().is_ok() {
                    let mut vehicles = Vec::with_capacity(controllers.len() * repeat);
                    for (index, controller) in controllers.iter().enumerate() {
                        let controller = controller.cast_exact::<$class>().map_err(|_| {
                            let wanted = concat!("of the first's class ", stringify!($law));
                            wrong_class(index, wanted, controller)
                        })?;
                        let vehicle = controller.try_borrow()?.vehicle();
                        vehicles.extend(std::iter::repeat_n(vehicle, repeat));
                    }
                    return Ok(Self::$law(Batch::resume(vehicles)));
                }
            )+};
        }
        try_each!(
            Pop(PyPop),
            PreviewPop(PyPreviewPop),
            Pid(PyPid),
            PurePursuit(PyPurePursuit),
            Stanley(PyStanley),
            BangBang(PyBangBang)
        );
        Err(wrong_class(0, "a controller of popsteer", first))
    }

    pub(crate) fn len(&self) -> usize {
        each!(self, batch => batch.len())
    }

    /// The states, in order.
    pub(crate) fn states<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyList>> {
        match self {
            Self::Pop(batch) => PyList::new(py, batch.states().map(PyPopState::from_core)),
            Self::PreviewPop(batch) => {
                PyList::new(py, batch.states().map(PyPreviewPopState::from_core))
            }
            Self::Pid(batch) => PyList::new(py, batch.states().map(PyPidState::from_core)),
            Self::PurePursuit(batch) => {
                PyList::new(py, batch.states().map(PyPurePursuitState::from_core))
            }
            Self::Stanley(batch) => PyList::new(py, batch.states().map(PyStanleyState::from_core)),
            Self::BangBang(batch) => {
                PyList::new(py, batch.states().map(PyBangBangState::from_core))
            }
        }
    }

    /// Does `work` on the vehicles without the interpreter's lock; `work` is given the vehicles.
    pub(crate) fn work(
        &mut self,
        py: Python<'_>,
        work: impl FnOnce(&mut Self) -> Result<(), BatchError> + Send,
    ) -> PyResult<()> {
        let outcome = if self.len() <= CHUNK {
            py.detach(|| work(self))
        } else {
            let pool = pool::shared()?;
            py.detach(|| pool.install(|| work(self)))
        };
        outcome.map_err(|refused| match refused.vehicle {
            Some(vehicle) => entry_error(py, vehicle, refused.error),
            None => refused.error.into_py_err(py),
        })
    }
}

fn wrong_class(index: usize, wanted: &str, got: &Bound<'_, PyAny>) -> PyErr {
    let got = got.get_type();
    PyTypeError::new_err(format!("controllers[{index}] must be {wanted}, got {got}"))
}
