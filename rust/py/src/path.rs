//! The path: arrays in, geometry out. PyO3 wants the methods of a class in one block; half of this
//! one is their documentation.

use std::sync::Arc;

use numpy::{PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1};
use popsteer_core::bounds::{MAX_COORDINATE, MAX_YAW};
use popsteer_core::error::{InputError, input_in_range as checked};
use popsteer_core::path::lookahead;
use popsteer_core::path::preview::Preview;
use popsteer_core::path::relocalise::relocalise;
use popsteer_core::path::resample::{self, Grid};
use popsteer_core::path::sound::{Fault, Mend};
use popsteer_core::path::{ClosestPoint, Path, PathView, locate, projection};
use popsteer_core::{Point, Vehicle, math};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList, PyTuple, PyType};

use crate::errors::Raises;
use crate::params::Count;
use crate::projection::{PyLookahead, PyProjection};
use crate::waypoints::Waypoints;

/// A reference path: waypoints, copied once and validated.
///
/// Parameters
/// ----------
/// xy : array_like
///     Waypoints, shape (N, 2) [m]; N >= 2, or 3 for a closed path.
/// speed : array_like, optional
///     Reference speed at each waypoint, shape (N,) [m/s]; negative where the path that leaves it
///     is driven backwards. Where it is 0 the sign of the next waypoint's counts. A sign that changes a
///     waypoint beside a cusp is taken to change there, and `mended` says so.
/// closed : bool, default False
///     Whether the last waypoint leads back to the first, which is then not repeated.
/// reverse : sequence of bool, optional
///     For each waypoint whether the segment that leaves it is driven backwards, shape (N,); by
///     default the signs of the speeds say so.
/// grade : array_like, optional
///     Slope along the path at each waypoint, rise over run, shape (N,); positive uphill in the
///     order of the waypoints. By default the path is level.
/// yaw : array_like or "spline", optional
///     The vehicle's heading on the path at each waypoint as its planner has it, shape (N,) [rad];
///     it points against the order of the waypoints where the path is driven backwards. "spline":
///     heading and curvature are those of the natural cubic spline through the waypoints, for
///     coarse ones without noise. By default the path is its segments.
/// curvature : array_like, optional
///     The vehicle's curvature on the path at each waypoint, tan(wheels' angle) / wheelbase, shape
///     (N,) [1/m]; without a yaw the heading is that of the spline, which then has to agree.
/// mend : bool, default True
///     Whether to mend what is certainly no part of a path, and to refuse what may be: see Notes.
///     False: the waypoints as they stand.
/// source : str, optional
///     Where the waypoints came from and how they were read, kept for those who ask.
///
/// Raises
/// ------
/// PathError
///     If the shape is wrong, a number is not finite or beyond its bound (1e9 m, 1e4 m/s, a slope
///     of 1), neighbours coincide (unless mended), the path turns back on itself and nothing says that
///     it is driven backwards, a gap is far longer than the spacing and the path turns there, most
///     waypoints turn back, or the waypoints contradict the yaw (by more than 0.35 rad over
///     a metre, or a turn of 1 rad, before or after) or the curvature (by more than 0.35 rad and a
///     fifth of all turns up to there); names the waypoint.
///
/// Notes
/// -----
/// Mended, and listed in `mended`: waypoints at one place, of which the last stays; the first waypoint
/// repeated at the end of a closed path; two neighbours swapped; a step back over what the path passes
/// again; a standstill recorded in the noise of its position; a first or last stretch, shorter than the
/// spacing, that points aside. A controller also smooths an end over its wheelbase if no vehicle of its
/// size drives it, as a goal 5 cm aside after 10 cm; see `mended` of its `path`. With `reverse`, a negative
/// speed, a `yaw` or a `curvature` folds are cusps, and only waypoints at one place are mended, and changes of
/// gear a waypoint beside their cusp. Lengths are compared with the usual spacing.
///
/// Examples
/// --------
/// >>> path = popsteer.Path([(0.0, 0.0), (3.0, 0.0), (3.0, 4.0)])
/// >>> len(path), path.length
/// (3, 7.0)
/// >>> path.project(1.0, 0.5).cross_track_error
/// 0.5
/// >>> path = popsteer.Path([(x, 0.0) for x in (0, 1, 2, 4, 3, 5, 6, 7)])
/// >>> path.mended
/// ('put 1 swapped pair of waypoints in order, at waypoint 3',)
#[pyclass(frozen, name = "Path", module = "popsteer")]
#[derive(Debug)]
pub(crate) struct PyPath(pub(crate) Arc<Path>, Option<String>);

impl PyPath {
    /// A path that was made here, of no file.
    pub(crate) const fn new(path: Arc<Path>) -> Self {
        Self(path, None)
    }

    pub(crate) fn view(&self) -> PathView<'_> {
        self.0.view()
    }

    /// The waypoint `nearest` to start from, by default the nearest of all.
    fn start(&self, nearest: Option<Count>, position: Point) -> Result<usize, InputError> {
        match nearest {
            None => Ok(projection::nearest_waypoint(&self.view(), position)),
            Some(index) => self.index("nearest", index),
        }
    }

    fn index(&self, field: &'static str, index: Count) -> Result<usize, InputError> {
        index.below(self.view().len(), field)
    }

    /// The grid around a waypoint, where it is not too large to visit all of it.
    fn grid(
        &self,
        nearest: usize,
        fields: (&'static str, &'static str),
        ahead: f64,
        spacing: f64,
    ) -> Raises<Grid<'_>> {
        checked(fields.0, ahead, 1e-3, 1e6)?;
        checked(fields.1, spacing, 1e-4, 1e3)?;
        let view = self.view();
        let window = resample::window(&view, nearest, ahead);
        Ok(Grid::new(view, window, spacing).checked()?)
    }
}

#[pymethods]
impl PyPath {
    #[new]
    #[pyo3(
        signature = (xy, *more, speed=None, closed=false, reverse=None, grade=None, yaw=None, curvature=None, mend=true, source=None),
        text_signature = "(xy, *, speed=None, closed=False, reverse=None, grade=None, yaw=None, curvature=None, mend=True, source=None)"
    )]
    fn py_new(
        xy: &Bound<'_, PyAny>,
        more: &Bound<'_, PyTuple>,
        speed: Option<&Bound<'_, PyAny>>,
        closed: bool,
        reverse: Option<Vec<bool>>,
        grade: Option<&Bound<'_, PyAny>>,
        yaw: Option<&Bound<'_, PyAny>>,
        curvature: Option<&Bound<'_, PyAny>>,
        mend: bool,
        source: Option<String>,
    ) -> Raises<Self> {
        if !more.is_empty() {
            let words = "Path takes one array of waypoints, shape (N, 2): \
                         Path(numpy.column_stack((x, y)), speed=...)";
            return Err(PyTypeError::new_err(words).into());
        }
        let is_spline =
            yaw.is_some_and(|yaw| yaw.extract::<&str>().is_ok_and(|text| text == "spline"));
        let yaw = yaw.filter(|_| !is_spline);
        let given = Waypoints::read(xy, reverse, [speed, grade, yaw, curvature])?;
        let [speed, grade, yaw, curvature] = given.others.each_ref().map(Option::as_deref);
        let reverse = given.reverse.as_deref();
        let directed = yaw.is_some() || curvature.is_some();
        let mut path = if mend {
            Path::sound(&given.x, &given.y, speed, reverse, closed, directed)?
        } else {
            let path = Path::new(&given.x, &given.y, speed, closed)?;
            match reverse {
                Some(reverse) => path.with_reverse(reverse)?,
                None => path,
            }
        };
        if let Some(grade) = grade {
            path = path.with_grade(grade)?;
        }
        if is_spline || yaw.is_some() || curvature.is_some() {
            path = path.with_yaw(yaw, curvature)?;
        }
        Ok(Self(Arc::new(path), source))
    }

    /// Read a path from a file: a table (CSV, `;`, tabs, white space), GPX or GeoJSON.
    ///
    /// Names in a head, or in the comment directly above the numbers, say what the columns are and
    /// in what unit; without names it is what they show themselves to be. docs/files.md lists what
    /// is read. `source` says what was.
    ///
    /// Parameters
    /// ----------
    /// file : str or path-like
    ///     The file.
    /// closed : bool, default False
    ///     Whether the last waypoint leads back to the first.
    /// columns : str, sequence of str or mapping of str to str, optional
    ///     What its columns are, where they do not say so: ``"x,y,-,speed [km/h]"`` in their order,
    ///     ``-`` for what is left out; or ``"speed=V [km/h]"`` by their names.
    /// origin : tuple of float, optional
    ///     Latitude and longitude [deg] of x = y = 0, where the file has these; by default the
    ///     first waypoint. Needs the extra ``geo``.
    ///
    /// Returns
    /// -------
    /// Path
    ///     The path.
    ///
    /// Raises
    /// ------
    /// PathError
    ///     If the file cannot be read, does not say what a column is, or makes no path; names file,
    ///     line and column, and the option that settles it.
    /// ConfigError
    ///     If `columns` are not known.
    ///
    /// Examples
    /// --------
    /// >>> import pathlib, tempfile
    /// >>> with tempfile.TemporaryDirectory() as folder:
    /// ...     file = pathlib.Path(folder, "lap.csv")
    /// ...     _ = file.write_text("x [m],y [m],v [km/h]\n0,0,18\n5,0,36\n")
    /// ...     path = popsteer.Path.from_csv(file)
    /// >>> path.speed.tolist(), path.source
    /// ([5.0, 10.0], 'lap.csv: 2 waypoints of x (x [m]), y (y [m]), speed (v [km/h])')
    #[classmethod]
    #[pyo3(signature = (file, *, closed=false, columns=None, origin=None))]
    fn from_csv<'py>(
        cls: &Bound<'py, PyType>,
        file: &Bound<'py, PyAny>,
        closed: bool,
        columns: Option<&Bound<'py, PyAny>>,
        origin: Option<(f64, f64)>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let py = cls.py();
        let tables = py.import("popsteer.tables")?;
        let options = PyDict::new(py);
        options.set_item("columns", columns)?;
        options.set_item("origin", origin)?;
        let read = tables.call_method("read_waypoints", (file,), Some(&options))?;
        let options = PyDict::new(py);
        options.set_item("closed", closed)?;
        tables.call_method("make_path", (cls, read), Some(&options))
    }

    /// Abscissas of the waypoints, a new array of shape (N,) [m].
    #[getter]
    fn x<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, self.view().x())
    }

    /// Ordinates of the waypoints, a new array of shape (N,) [m].
    #[getter]
    fn y<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, self.view().y())
    }

    /// Arc length at each waypoint, a new array of shape (N,) [m].
    #[getter]
    fn s<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, self.view().s())
    }

    /// Reference speed at each waypoint, a new array of shape (N,) [m/s]; None without.
    #[getter]
    fn speed<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyArray1<f64>>> {
        Some(PyArray1::from_slice(py, self.view().speed()?))
    }

    /// For each segment, by the waypoint at its start, whether it is driven backwards, shape (N,);
    /// None where all is driven forward.
    #[getter]
    fn reverse<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyArray1<bool>>> {
        Some(PyArray1::from_slice(py, self.view().reverse()?))
    }

    /// Slope along the path at each waypoint, rise over run, a new array of shape (N,); None where
    /// the path is level.
    #[getter]
    fn grade<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyArray1<f64>>> {
        Some(PyArray1::from_slice(py, self.view().grade()?))
    }

    /// The vehicle's heading at each waypoint, a new array of shape (N,) [rad]; None where the path
    /// is its segments.
    #[getter]
    fn yaw<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyArray1<f64>>> {
        Some(PyArray1::from_slice(py, self.view().yaw()?))
    }

    /// The vehicle's curvature at each waypoint, a new array of shape (N,) [1/m]; None without.
    #[getter]
    fn curvature<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyArray1<f64>>> {
        Some(PyArray1::from_slice(py, self.view().curvature()?))
    }

    /// What was mended in the waypoints as given, a line for each kind of fault; empty where nothing
    /// was.
    #[getter]
    fn mended<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        PyTuple::new(py, self.0.mends().iter().map(ToString::to_string))
    }

    /// Where the waypoints came from, how they were read, and what was mended in them; None of a path
    /// that was made of arrays.
    #[getter]
    fn source(&self) -> Option<String> {
        let mut said = self.1.clone()?;
        for mend in self.0.mends() {
            said.push_str("; ");
            said.push_str(&mend.to_string());
        }
        Some(said)
    }

    /// Arc length of the whole path [m], the closing segment included.
    #[getter]
    fn length(&self) -> f64 {
        self.view().length()
    }

    /// Whether the last waypoint leads back to the first.
    #[getter]
    fn closed(&self) -> bool {
        self.view().is_closed()
    }

    fn __len__(&self) -> usize {
        self.view().len()
    }

    fn __repr__(&self) -> String {
        let view = self.view();
        let closed = if view.is_closed() { ", closed" } else { "" };
        let (waypoints, length) = (view.len(), view.length());
        format!("<Path of {waypoints} waypoints, {length:.1} m{closed}>")
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, Remade<'py>)> {
        let view = self.view();
        let flat = view.x().iter().zip(view.y()).flat_map(|(&x, &y)| [x, y]);
        let xy = PyArray1::from_iter(py, flat).reshape([view.len(), 2])?;
        let options = PyDict::new(py);
        options.set_item("speed", self.speed(py))?;
        options.set_item("closed", self.closed())?;
        options.set_item("reverse", self.reverse(py))?;
        options.set_item("grade", self.grade(py))?;
        options.set_item("mend", false)?;
        options.set_item("source", self.1.as_deref())?;
        if self.0.is_spline() {
            options.set_item("yaw", "spline")?;
        } else {
            options.set_item("yaw", self.yaw(py))?;
            options.set_item("curvature", self.curvature(py))?;
        }
        let kind = |fault| Fault::ALL.iter().position(|&each| each == fault);
        let mends = self.0.mends().iter();
        let mends = mends.map(|mend| (kind(mend.fault), mend.times, mend.left_out, mend.index));
        let make = py.get_type::<Self>().getattr("_remake")?;
        let mends = PyList::new(py, mends)?;
        Ok((make, (xy.into_any(), options, mends, self.0.fits())))
    }

    /// The path that `__reduce__` took apart.
    #[classmethod]
    fn _remake(
        cls: &Bound<'_, PyType>,
        xy: &Bound<'_, PyAny>,
        options: &Bound<'_, PyDict>,
        mends: Vec<(usize, usize, usize, usize)>,
        fits: bool,
    ) -> PyResult<Self> {
        let path = cls.call((xy,), Some(options))?;
        let made = path.cast::<Self>()?.get();
        let path = Path::clone(&made.0);
        let mends = mends.iter().filter_map(|&(fault, times, left_out, index)| {
            let &fault = Fault::ALL.get(fault)?;
            Some(Mend {
                fault,
                times,
                left_out,
                index,
            })
        });
        let path = path.with_mends(&mends.collect::<Vec<_>>(), fits);
        Ok(Self(Arc::new(path), made.1.clone()))
    }

    /// Find the waypoint nearest to a position, of all.
    ///
    /// Parameters
    /// ----------
    /// x, y : float
    ///     Position [m].
    ///
    /// Returns
    /// -------
    /// int
    ///     Its index; the first of several as near.
    ///
    /// Raises
    /// ------
    /// InputError
    ///     If a coordinate is not finite or beyond its bound.
    fn nearest_waypoint(&self, x: f64, y: f64) -> Raises<usize> {
        let position = checked_point(x, y)?;
        Ok(projection::nearest_waypoint(&self.view(), position))
    }

    /// Find the closest point of a position near its last place, for a vehicle that drives along
    /// `yaw`.
    ///
    /// Of the segments from the one at `waypoint` until more than `reach` of arc before and behind
    /// it, each that is no farther off than the one before it and nearer than the one after it is a
    /// candidate. Of these it is the one of least distance plus a penalty that grows as the heading
    /// turns away from the path, up to `opposite_distance`. Other branches of the path are not
    /// searched, nor is what lies beyond a cusp. All controllers find their location like this.
    ///
    /// Parameters
    /// ----------
    /// x, y : float
    ///     Position [m].
    /// yaw : float
    ///     Direction of driving [rad].
    /// waypoint : int
    ///     The waypoint at which the segment of the last closest point starts.
    /// reach : float
    ///     How far along the path to look [m].
    /// opposite_distance : float, default 10.0
    ///     How much farther off the path counts where it leads against `yaw` [m]; controllers take
    ///     10/3 of their wheelbase.
    ///
    /// Returns
    /// -------
    /// Projection
    ///     The closest point.
    ///
    /// Raises
    /// ------
    /// InputError
    ///     If a number is not finite or beyond its bound, or the path has no such waypoint.
    ///
    /// Examples
    /// --------
    /// There, and back 0.5 m beside it:
    ///
    /// >>> path = popsteer.Path([(0.0, 0.0), (9.0, 0.0), (9.0, 0.5), (0.0, 0.5)])
    /// >>> path.locate(7.0, 0.4, 0.0, 0, 6.0).segment, path.locate(7.0, 0.4, 3.0, 0, 6.0).segment
    /// (0, 2)
    #[pyo3(signature = (x, y, yaw, waypoint, reach, *, opposite_distance=10.0))]
    fn locate(
        &self,
        x: f64,
        y: f64,
        yaw: f64,
        waypoint: Count,
        reach: f64,
        opposite_distance: f64,
    ) -> Raises<PyProjection> {
        let position = checked_point(x, y)?;
        let yaw = checked("yaw", yaw, -MAX_YAW, MAX_YAW)?;
        let waypoint = self.index("waypoint", waypoint)?;
        let reach = checked("reach", reach, 0.0, 1e9)?;
        let opposite = checked("opposite_distance", opposite_distance, 0.0, 1e9)?;
        let heading = Point::new(math::cos(yaw), math::sin(yaw));
        let view = self.view();
        let closest = locate::locate(&view, waypoint, position, heading, reach, opposite);
        Ok(PyProjection(closest.projection(&view)))
    }

    /// Find the first crossing of the lookahead circle ahead of a closest point on the path.
    ///
    /// At an end of the path and at a cusp the last segment goes on as a straight line, so there
    /// always is a crossing while the closest point lies within the circle. If the closest point is
    /// at least `lookahead` away, it is the answer itself. On a closed path that lies within the
    /// circle the answer is the waypoint at least a quarter round.
    ///
    /// Parameters
    /// ----------
    /// x, y : float
    ///     Where to measure from [m].
    /// lookahead : float
    ///     Lookahead distance ld [m].
    /// segment : int
    ///     The segment that carries the closest point of (x, y).
    ///
    /// Returns
    /// -------
    /// tuple of ((float, float), bool)
    ///     The point (x, y) [m], and whether it lies on the circle.
    ///
    /// Raises
    /// ------
    /// InputError
    ///     If a number is not finite or beyond its bound, or the path has no such segment.
    ///
    /// Examples
    /// --------
    /// >>> path = popsteer.Path([(0.0, 0.0), (10.0, 0.0)])
    /// >>> path.get_crossing(8.0, 3.0, 5.0, 0)
    /// ((12.0, 0.0), True)
    fn get_crossing(
        &self,
        x: f64,
        y: f64,
        lookahead: f64,
        segment: Count,
    ) -> Raises<((f64, f64), bool)> {
        let position = checked_point(x, y)?;
        checked("lookahead", lookahead, 0.0, 1e6)?;
        let segment = self.index("segment", segment)?;
        let view = self.view();
        let segment = segment.min(view.segments() - 1);
        let closest = ClosestPoint::new(&view, segment, position);
        let (point, on_circle) = lookahead::get_crossing(&view, &closest, position, lookahead);
        Ok(((point.x, point.y), on_circle))
    }

    /// Find the waypoint to start from after a jump: the nearest one whose direction fits.
    ///
    /// The segment of least distance counts, each distance with up to `opposite_distance` more the
    /// less a vehicle that looks along `yaw` would drive along it; the first of several. The
    /// heading thus tells branches apart that cross or lie alongside. Where the path is driven
    /// backwards the vehicle looks against it.
    ///
    /// A call takes microseconds where few waypoints are as near, and visits all of them at worst,
    /// as at the centre of a circle.
    ///
    /// Parameters
    /// ----------
    /// x, y : float
    ///     Position [m].
    /// yaw : float
    ///     Heading [rad]; need not be wrapped.
    /// opposite_distance : float, default 10.0
    ///     How much farther off a segment counts that leads the opposite way [m]; controllers take
    ///     10/3 of their wheelbase.
    ///
    /// Returns
    /// -------
    /// int
    ///     Index of the waypoint at which the segment starts.
    ///
    /// Raises
    /// ------
    /// InputError
    ///     If a number is not finite or beyond its bound.
    ///
    /// Examples
    /// --------
    /// >>> path = popsteer.Path([(0.0, 0.0), (9.0, 0.0), (9.0, 2.0), (0.0, 2.0)])
    /// >>> path.relocalise(0.5, 0.9, 0.1), path.relocalise(0.5, 0.9, 3.1)
    /// (0, 2)
    #[pyo3(signature = (x, y, yaw, *, opposite_distance=10.0))]
    fn relocalise(&self, x: f64, y: f64, yaw: f64, opposite_distance: f64) -> Raises<usize> {
        let position = checked_point(x, y)?;
        let yaw = checked("yaw", yaw, -MAX_YAW, MAX_YAW)?;
        let opposite = checked("opposite_distance", opposite_distance, 0.0, 1e9)?;
        Ok(relocalise(&self.view(), position, yaw, opposite))
    }

    /// Project a position exactly onto the segments at a waypoint.
    ///
    /// Before the first and beyond the last waypoint of an open path the end segments go on as
    /// straight lines, so the cross-track error stays the offset to the side.
    ///
    /// Parameters
    /// ----------
    /// x, y : float
    ///     Position [m].
    /// nearest : int, optional
    ///     The waypoint; by default the nearest of all.
    ///
    /// Returns
    /// -------
    /// Projection
    ///     The nearer closest point on the two segments that meet at the waypoint.
    ///
    /// Raises
    /// ------
    /// InputError
    ///     If `nearest` is no waypoint, or a coordinate is not finite or beyond its bound.
    #[pyo3(signature = (x, y, nearest=None))]
    fn project(&self, x: f64, y: f64, nearest: Option<Count>) -> Raises<PyProjection> {
        let position = checked_point(x, y)?;
        let nearest = self.start(nearest, position)?;
        let closest = projection::project(&self.view(), nearest, position);
        Ok(PyProjection(closest))
    }

    /// Give the direction of the segment that leads to a waypoint.
    ///
    /// The path's heading as the paper's published code takes it.
    ///
    /// Parameters
    /// ----------
    /// nearest : int
    ///     The waypoint.
    ///
    /// Returns
    /// -------
    /// float
    ///     Direction [rad]; of the first segment at the start of an open path.
    ///
    /// Raises
    /// ------
    /// InputError
    ///     If `nearest` is no waypoint.
    fn path_yaw_behind(&self, nearest: Count) -> Raises<f64> {
        let nearest = self.index("nearest", nearest)?;
        Ok(projection::path_yaw_behind(&self.view(), nearest))
    }

    /// Give the reference speed beside a position.
    ///
    /// Parameters
    /// ----------
    /// x, y : float
    ///     Position [m].
    /// nearest : int, optional
    ///     The waypoint nearest to it; by default the nearest of all.
    ///
    /// Returns
    /// -------
    /// float or None
    ///     Speed [m/s], between the waypoints' linearly; None where the path has no speeds.
    ///
    /// Raises
    /// ------
    /// InputError
    ///     If `nearest` is no waypoint, or a coordinate is not finite or beyond its bound.
    #[pyo3(signature = (x, y, nearest=None))]
    fn reference_speed(&self, x: f64, y: f64, nearest: Option<Count>) -> Raises<Option<f64>> {
        let closest = self.project(x, y, nearest)?.0;
        Ok(projection::reference_speed(&self.view(), &closest))
    }

    /// Give the window around a waypoint: one waypoint behind it to so much arc ahead.
    ///
    /// Parameters
    /// ----------
    /// nearest : int
    ///     The waypoint.
    /// ahead : float, default 20.0
    ///     Arc ahead of it [m].
    ///
    /// Returns
    /// -------
    /// tuple of int
    ///     First segment, number of segments.
    ///
    /// Raises
    /// ------
    /// InputError
    ///     If `nearest` is no waypoint or `ahead` out of range.
    #[pyo3(signature = (nearest, ahead=20.0))]
    fn window(&self, nearest: Count, ahead: f64) -> Raises<(usize, usize)> {
        let nearest = self.index("nearest", nearest)?;
        checked("ahead", ahead, 1e-3, 1e6)?;
        let window = resample::window(&self.view(), nearest, ahead);
        Ok((window.first, window.segments))
    }

    /// Re-discretise the window around a waypoint.
    ///
    /// Parameters
    /// ----------
    /// nearest : int
    ///     The waypoint.
    /// ahead : float, default 20.0
    ///     Arc ahead of it [m].
    /// spacing : float, default 0.01
    ///     Greatest distance of neighbours [m].
    ///
    /// Returns
    /// -------
    /// ndarray
    ///     Points, shape (M, 2) [m].
    ///
    /// Raises
    /// ------
    /// InputError
    ///     If `nearest` is no waypoint, or a length is out of range.
    /// PathError
    ///     If the grid would have more than 10,000,000 points.
    #[pyo3(signature = (nearest, ahead=20.0, spacing=0.01))]
    fn resample<'py>(
        &self,
        py: Python<'py>,
        nearest: Count,
        ahead: f64,
        spacing: f64,
    ) -> Raises<Bound<'py, PyArray2<f64>>> {
        let nearest = self.index("nearest", nearest)?;
        let grid = self.grid(nearest, ("ahead", "spacing"), ahead, spacing)?;
        let flat: Vec<f64> = grid.points().flat_map(|point| [point.x, point.y]).collect();
        let points = flat.len() / 2;
        Ok(PyArray1::from_vec(py, flat).reshape([points, 2])?)
    }

    /// Search the re-discretised window for the lookahead point.
    ///
    /// The first point whose distance from the position differs from `lookahead` by at most
    /// `tolerance`, else the last: the paper's `get_lookahead_point_index` (Equation 5) and
    /// `get_lookahead_point` in one.
    ///
    /// Parameters
    /// ----------
    /// x, y : float
    ///     Position [m].
    /// lookahead : float
    ///     Lookahead distance [m].
    /// nearest : int, optional
    ///     The waypoint nearest to the position; by default the nearest of all.
    /// tolerance : float, default 0.01
    ///     Threshold of the comparison [m].
    /// window_ahead : float, default 20.0
    ///     Arc ahead of the nearest waypoint that is searched [m].
    /// grid_spacing : float, default 0.01
    ///     Greatest distance of neighbours on the grid [m].
    ///
    /// Returns
    /// -------
    /// Lookahead
    ///     Index, point, and whether it lies on the circle.
    ///
    /// Raises
    /// ------
    /// InputError
    ///     If `nearest` is no waypoint, or a number is out of range.
    /// PathError
    ///     If the grid would have more than 10,000,000 points.
    #[pyo3(signature = (
        x, y, lookahead, *, nearest=None, tolerance=0.01, window_ahead=20.0, grid_spacing=0.01
    ))]
    fn get_lookahead_point(
        &self,
        x: f64,
        y: f64,
        lookahead: f64,
        nearest: Option<Count>,
        tolerance: f64,
        window_ahead: f64,
        grid_spacing: f64,
    ) -> Raises<PyLookahead> {
        let position = checked_point(x, y)?;
        let nearest = self.start(nearest, position)?;
        checked("lookahead", lookahead, 0.0, 1e6)?;
        checked("tolerance", tolerance, 1e-9, 1e3)?;
        let names = ("window_ahead", "grid_spacing");
        let grid = self.grid(nearest, names, window_ahead, grid_spacing)?;
        let found = lookahead::get_lookahead_point(&grid, position, lookahead, tolerance);
        Ok(PyLookahead(found))
    }

    /// Search the re-discretised window for the lookahead point; give its index alone.
    ///
    /// Parameters and errors as `get_lookahead_point` (the paper's Equation 5).
    ///
    /// Returns
    /// -------
    /// int
    ///     Index in ``resample(nearest, window_ahead, grid_spacing)``.
    #[pyo3(signature = (
        x, y, lookahead, *, nearest=None, tolerance=0.01, window_ahead=20.0, grid_spacing=0.01
    ))]
    fn get_lookahead_point_index(
        &self,
        x: f64,
        y: f64,
        lookahead: f64,
        nearest: Option<Count>,
        tolerance: f64,
        window_ahead: f64,
        grid_spacing: f64,
    ) -> Raises<usize> {
        let (ahead, spacing) = (window_ahead, grid_spacing);
        self.get_lookahead_point(x, y, lookahead, nearest, tolerance, ahead, spacing)
            .map(|found| found.0.index)
    }
}

/// The path as a vehicle of this size drives its ends.
pub(crate) fn fitted(py: Python<'_>, path: Py<PyPath>, vehicle: &Vehicle) -> PyResult<Py<PyPath>> {
    let given = path.get();
    match given.0.fitted(vehicle) {
        Some(fitted) => Py::new(py, PyPath(Arc::new(fitted), given.1.clone())),
        None => Ok(path),
    }
}

/// What `_remake` takes.
type Remade<'py> = (
    Bound<'py, PyAny>,
    Bound<'py, PyDict>,
    Bound<'py, PyList>,
    bool,
);

/// The path's direction at `distances` [m] ahead of `arc_length` [m] on segment `segment`, as preview
/// POP takes it: that of the path's own headings, or else smoothed over `base` [m]. Each is counted on
/// from the one before, so that none wraps.
#[pyfunction(name = "_path_headings")]
pub(crate) fn path_headings<'py>(
    py: Python<'py>,
    path: &PyPath,
    base: f64,
    segment: Count,
    arc_length: f64,
    distances: PyReadonlyArray1<'_, f64>,
) -> Raises<Bound<'py, PyArray1<f64>>> {
    let segment = path.index("segment", segment)?;
    let distances = distances.as_slice()?;
    let far = distances.last().copied().unwrap_or(0.0);
    let view = path.view();
    let mut preview = Preview::new(&view, base, segment, arc_length, far);
    let mut heading = preview.path_yaw(arc_length);
    let headings = distances.iter().map(|distance| {
        heading += math::wrap(preview.path_yaw(arc_length + distance) - heading);
        heading
    });
    let headings = headings.collect();
    Ok(PyArray1::from_vec(py, headings))
}

/// A position whose coordinates are within the bounds.
fn checked_point(x: f64, y: f64) -> Result<Point, InputError> {
    checked("x", x, -MAX_COORDINATE, MAX_COORDINATE)?;
    checked("y", y, -MAX_COORDINATE, MAX_COORDINATE)?;
    Ok(Point::new(x, y))
}
