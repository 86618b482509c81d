//! The wheels along a log, for the identification.

use numpy::{PyArray1, PyReadonlyArray1};
use popsteer_sim::LoggedWheels;
use pyo3::prelude::*;

type Floats<'py> = Bound<'py, PyArray1<f64>>;

/// The wheels under the commands [rad] of a log, which begin at `times` [s], without dead time.
#[pyclass(name = "_Wheels", module = "popsteer._core", frozen)]
pub(crate) struct PyWheels(LoggedWheels);

#[pymethods]
impl PyWheels {
    #[new]
    fn new(
        times: PyReadonlyArray1<'_, f64>,
        commands: PyReadonlyArray1<'_, f64>,
        lag: f64,
        rate: Option<f64>,
    ) -> Self {
        let (times, commands) = (times.as_array().to_vec(), commands.as_array().to_vec());
        Self(LoggedWheels::new(times, commands, lag, rate))
    }

    #[getter]
    fn times<'py>(&self, py: Python<'py>) -> Floats<'py> {
        PyArray1::from_slice(py, self.0.times())
    }

    #[getter]
    fn commands<'py>(&self, py: Python<'py>) -> Floats<'py> {
        PyArray1::from_slice(py, self.0.commands())
    }

    #[getter]
    fn lag(&self) -> f64 {
        self.0.lag()
    }

    #[getter]
    fn rate(&self) -> Option<f64> {
        self.0.rate()
    }

    /// The angle at the beginning of each command [rad].
    #[getter]
    fn angle<'py>(&self, py: Python<'py>) -> Floats<'py> {
        PyArray1::from_slice(py, self.0.angles())
    }

    /// For how long the rate is limited from the beginning of each command on [s].
    #[getter]
    fn turning<'py>(&self, py: Python<'py>) -> Floats<'py> {
        PyArray1::from_slice(py, self.0.turning())
    }

    /// Give the angle at these times [rad].
    fn at<'py>(&self, py: Python<'py>, times: PyReadonlyArray1<'_, f64>) -> PyResult<Floats<'py>> {
        Ok(PyArray1::from_vec(py, self.0.at(times.as_slice()?)))
    }

    /// Give the integral of the angle from the first command to these times [rad s].
    fn integral<'py>(
        &self,
        py: Python<'py>,
        times: PyReadonlyArray1<'_, f64>,
    ) -> PyResult<Floats<'py>> {
        Ok(PyArray1::from_vec(py, self.0.integral(times.as_slice()?)))
    }

    /// Give the integral from the first of `edges` [s] to each of the angle behind `play` [rad s].
    fn behind_play<'py>(
        &self,
        py: Python<'py>,
        edges: PyReadonlyArray1<'_, f64>,
        dead_time: f64,
        scale: f64,
        offset: f64,
        play: f64,
    ) -> PyResult<Floats<'py>> {
        let found = self
            .0
            .behind_play(edges.as_slice()?, dead_time, scale, offset, play);
        Ok(PyArray1::from_vec(py, found))
    }
}

/// `y_k = kept_k y_{k-1} + added_k` from 0 on; `added` has its rows one after the other.
#[pyfunction(name = "_recursion")]
pub(crate) fn recursion<'py>(
    py: Python<'py>,
    kept: PyReadonlyArray1<'_, f64>,
    added: PyReadonlyArray1<'_, f64>,
) -> PyResult<Floats<'py>> {
    let found = popsteer_sim::logged::recursion(kept.as_slice()?, added.as_slice()?);
    Ok(PyArray1::from_vec(py, found))
}

/// The mean of each `cell` [s] of a signal behind first-order lags [s], one for each cell.
#[pyfunction(name = "_lagged")]
pub(crate) fn lagged<'py>(
    py: Python<'py>,
    given: PyReadonlyArray1<'_, f64>,
    lags: PyReadonlyArray1<'_, f64>,
    cell: f64,
) -> PyResult<Floats<'py>> {
    let found = popsteer_sim::logged::lagged(given.as_slice()?, lags.as_slice()?, cell);
    Ok(PyArray1::from_vec(py, found))
}
