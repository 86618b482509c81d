//! The threads that batches and many runs share.

use std::sync::{Arc, Mutex, PoisonError};

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};

/// The pool, with the process that made it.
static SHARED: Mutex<Option<(u32, Arc<ThreadPool>)>> = Mutex::new(None);

/// The pool of this process: a thread a core, or as many as `RAYON_NUM_THREADS` says.
///
/// rayon's own would not do: a process forked by `multiprocessing` inherits that one without its
/// threads, and would wait for them without end.
pub(crate) fn shared() -> PyResult<Arc<ThreadPool>> {
    let process = std::process::id();
    let mut shared = SHARED.lock().unwrap_or_else(PoisonError::into_inner);
    match &*shared {
        Some((owner, pool)) if *owner == process => Ok(Arc::clone(pool)),
        _ => {
            let pool = Arc::new(of_threads(0)?);
            let inherited = shared.replace((process, Arc::clone(&pool)));
            // To drop it would be to speak to threads that are not there.
            std::mem::forget(inherited);
            Ok(pool)
        }
    }
}

/// A pool of so many threads; 0 as in [`shared`].
pub(crate) fn of_threads(count: usize) -> PyResult<ThreadPool> {
    ThreadPoolBuilder::new()
        .num_threads(count)
        .thread_name(|index| format!("popsteer-{index}"))
        .build()
        .map_err(|error| PyRuntimeError::new_err(format!("cannot start threads: {error}")))
}
