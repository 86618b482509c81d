//! The path that owns its waypoints.

use alloc::boxed::Box;
use alloc::sync::Arc;
use alloc::vec;
use alloc::vec::Vec;

use super::boxes::{self, Bounds};
use super::measure::{Measures, check_column, check_length, check_waypoints, lengths};
use super::shape::spline;
use super::sound::{Fault, Mend, Sound, at_cusps, fit_ends, sound};
use super::view::PathView;
use crate::bounds::MAX_SPEED;
use crate::error::PathError;
use crate::math::tan;
use crate::vehicle::Vehicle;

/// Waypoints copied once; [`Path::view`] lends them to the controllers.
///
/// # Examples
///
/// ```
/// let path = popsteer_core::Path::new(&[0.0, 3.0], &[0.0, 4.0], None, false)?;
/// assert_eq!(path.view().length(), 5.0);
/// # Ok::<(), popsteer_core::PathError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Path {
    x: Box<[f64]>,
    y: Box<[f64]>,
    s: Box<[f64]>,
    speed: Option<Box<[f64]>>,
    reverse: Option<Box<[bool]>>,
    grade: Option<Box<[f64]>>,
    yaw: Option<Box<[f64]>>,
    curvature: Option<Box<[f64]>>,
    is_spline: bool,
    measures: Measures,
    closed: bool,
    index: Option<Box<[Bounds]>>,
    /// The segments that end at a cusp, where any is driven backwards.
    ends: Option<Box<[usize]>>,
    /// Which of the given waypoints it has, where they were mended.
    mended: Option<Box<Mended>>,
    /// Whether its ends may be fitted to a vehicle.
    fits: bool,
}

/// What was made of the waypoints as given.
#[derive(Clone, Debug, PartialEq)]
struct Mended {
    kept: Box<[usize]>,
    given: usize,
    mends: Vec<Mend>,
}

impl Mended {
    /// Of waypoints that all stay.
    fn whole(count: usize) -> Self {
        Self {
            kept: (0..count).collect(),
            given: count,
            mends: Vec::new(),
        }
    }
}

impl Path {
    /// The path of waypoints as people have them: mended where that is certain, and refused where it
    /// is not. See [`sound`](super::sound) for what is mended.
    ///
    /// `reverse` and a negative speed say where the path is driven backwards. Either, or `directed`
    /// for headings of the vehicle that are given later, says that folds are cusps: they stay. The
    /// columns that are given later still have an entry for each waypoint as given.
    ///
    /// # Errors
    ///
    /// [`PathError`], as [`Path::new`] and [`sound`](super::sound::sound).
    ///
    /// # Examples
    ///
    /// ```
    /// let swapped = [0.0, 1.0, 2.0, 4.0, 3.0, 5.0, 6.0, 7.0];
    /// let path = popsteer_core::Path::sound(&swapped, &[0.0; 8], None, None, false, false)?;
    /// assert_eq!(path.view().x()[3..5], [3.0, 4.0]);
    /// assert_eq!(path.mends().len(), 1);
    /// # Ok::<(), popsteer_core::PathError>(())
    /// ```
    pub fn sound(
        x: &[f64],
        y: &[f64],
        speed: Option<&[f64]>,
        reverse: Option<&[bool]>,
        closed: bool,
        directed: bool,
    ) -> Result<Self, PathError> {
        check_waypoints(x, y, speed, closed, x.len())?;
        if let Some(reverse) = reverse {
            check_length("reverse", reverse.len(), x.len())?;
        }
        let backwards = speed.is_some_and(|speed| speed.iter().any(|&speed| speed < 0.0));
        let directed = directed || backwards || reverse.is_some();
        let Sound { kept, mends } = sound(x, y, closed, directed)?;
        let enough = |kept: &[usize]| kept.len() >= if closed { 3 } else { 2 };
        let fits = !directed && !closed;
        let Some(kept) = kept.filter(|kept| enough(kept)) else {
            let path = Self::of_checked(x, y, speed, closed)?;
            let path = Self { fits, ..path };
            return match reverse {
                Some(reverse) => path.with_reverse(reverse)?,
                None => path,
            }
            .with_gears_at_cusps();
        };
        let speed: Option<Vec<f64>> = speed.map(|speed| pick(speed, &kept));
        let path = Self::new(&pick(x, &kept), &pick(y, &kept), speed.as_deref(), closed)?;
        let path = match reverse {
            Some(reverse) => path.with_reverse(&pick(reverse, &kept))?,
            None => path,
        };
        let given = x.len();
        let mended = Mended { kept, given, mends };
        Self {
            mended: Some(Box::new(mended)),
            fits,
            ..path
        }
        .with_gears_at_cusps()
    }

    /// The same path with each change of gear at its cusp.
    fn with_gears_at_cusps(mut self) -> Result<Self, PathError> {
        let found = self.reverse.as_deref();
        let found = found.and_then(|reverse| at_cusps(&self.x, &self.y, reverse));
        let Some((gears, mut mend)) = found else {
            return Ok(self);
        };
        let count = self.x.len();
        let whole = || Box::new(Mended::whole(count));
        let mended = self.mended.get_or_insert_with(whole);
        mend.index = mended.kept.get(mend.index).copied().unwrap_or(mend.index);
        mended.mends.push(mend);
        self.with_reverse(&gears)
    }

    /// The same waypoints with ends that this vehicle drives, if the path was made by
    /// [`sound`](Self::sound) and they turn there as it cannot: as noise does, or a goal a hand's
    /// breadth aside. Controllers go on beyond an end in its direction. None if the path stays.
    pub fn fitted(&self, vehicle: &Vehicle) -> Option<Self> {
        let tightest = tan(vehicle.max_steer) / vehicle.turning_length(0.0);
        let fits = self.fits && self.yaw.is_none();
        let found = if fits {
            fit_ends(&self.x, &self.y, vehicle.wheelbase, tightest)
        } else {
            None
        };
        let (points, times) = found?;
        let (x, y): (Vec<f64>, Vec<f64>) = points.iter().map(|point| (point.x, point.y)).unzip();
        let path = Self::new(&x, &y, self.speed.as_deref(), false).ok()?;
        let mut mends = self.mends().to_vec();
        mends.push(Mend {
            fault: Fault::Undrivable,
            times,
            left_out: 0,
            index: if times > 1 { 0 } else { x.len() - 1 },
        });
        let grade = self.grade.clone();
        Some(Self { grade, ..path }.with_mends(&mends, false))
    }

    /// What was mended, at most once each kind.
    pub fn mends(&self) -> &[Mend] {
        self.mended.as_ref().map_or(&[], |mended| &mended.mends)
    }

    /// The shared path as this vehicle drives it: [`fitted`](Self::fitted), or the same.
    pub fn for_vehicle(path: Arc<Self>, vehicle: &Vehicle) -> Arc<Self> {
        match path.fitted(vehicle) {
            Some(fitted) => Arc::new(fitted),
            None => path,
        }
    }

    /// Whether [`fitted`](Self::fitted) looks at its ends.
    pub fn fits(&self) -> bool {
        self.fits
    }

    /// The same path, of which this was mended before, and whose ends may be fitted to a vehicle.
    pub fn with_mends(self, mends: &[Mend], fits: bool) -> Self {
        let mended = Mended {
            mends: mends.into(),
            ..Mended::whole(self.x.len())
        };
        Self {
            mended: (!mends.is_empty()).then(|| Box::new(mended)),
            fits,
            ..self
        }
    }

    /// A column of the waypoints as given, for those that the path has.
    fn kept<T: Copy>(&self, column: &[T]) -> Option<Vec<T>> {
        let mended = self.mended.as_ref()?;
        (column.len() == mended.given).then(|| pick(column, &mended.kept))
    }

    /// Copies waypoints `x`, `y` [m] and reference speeds [m/s] as they stand; `closed` leads the
    /// last waypoint back to the first.
    ///
    /// A segment is driven backwards where the speed at its start is negative; where that is 0,
    /// where the speed at its end is; where both are, as the segment before it.
    ///
    /// # Errors
    ///
    /// [`PathError`], as [`PathView::new`].
    pub fn new(
        x: &[f64],
        y: &[f64],
        speed: Option<&[f64]>,
        closed: bool,
    ) -> Result<Self, PathError> {
        check_waypoints(x, y, speed, closed, x.len())?;
        Self::of_checked(x, y, speed, closed)
    }

    fn of_checked(
        x: &[f64],
        y: &[f64],
        speed: Option<&[f64]>,
        closed: bool,
    ) -> Result<Self, PathError> {
        let mut s = vec![0.0; x.len()].into_boxed_slice();
        let measures = lengths(x, y, closed, &mut s)?;
        let backwards = speed.filter(|speed| speed.iter().any(|&speed| speed < 0.0));
        let mut path = Self {
            reverse: backwards.map(|speed| reverse_by_speed(speed, closed)),
            x: x.into(),
            y: y.into(),
            s,
            speed: speed.map(Into::into),
            grade: None,
            yaw: None,
            curvature: None,
            is_spline: false,
            measures,
            closed,
            index: None,
            ends: None,
            mended: None,
            fits: false,
        };
        path.index = boxes::build(x, y, closed);
        path.ends = path.section_ends();
        Ok(path)
    }

    /// The same path with the stretches that are driven backwards, as
    /// [`PathView::with_reverse`]; the signs of the speeds say nothing then.
    ///
    /// # Errors
    ///
    /// [`PathError::LengthMismatch`] unless there is an entry for each waypoint.
    pub fn with_reverse(self, reverse: &[bool]) -> Result<Self, PathError> {
        self.view().with_reverse(reverse)?;
        let reverse = reverse.contains(&true).then(|| reverse.into());
        let mut path = Self { reverse, ..self };
        path.ends = path.section_ends();
        Ok(path)
    }

    /// A copy with other reference speeds [m/s]; which stretches are driven backwards stays.
    ///
    /// # Errors
    ///
    /// [`PathError`]: not an entry for each waypoint, or one that is out of its range.
    pub fn with_speed(&self, speed: &[f64]) -> Result<Self, PathError> {
        check_column("speed", speed, self.x.len(), MAX_SPEED)?;
        Ok(Self {
            speed: Some(speed.into()),
            ..self.clone()
        })
    }

    /// The same path with the slope at each waypoint, as [`PathView::with_grade`].
    ///
    /// # Errors
    ///
    /// [`PathError`], as [`PathView::with_grade`].
    pub fn with_grade(self, grade: &[f64]) -> Result<Self, PathError> {
        let kept = self.kept(grade);
        let grade = kept.as_deref().unwrap_or(grade);
        self.view().with_grade(grade)?;
        Ok(Self {
            grade: Some(grade.into()),
            ..self
        })
    }

    /// The same path with the vehicle's heading and curvature at each waypoint, as
    /// [`PathView::with_yaw`]. What is not given is that of the natural cubic spline through the
    /// waypoints, but no curvature where the heading is given alone.
    ///
    /// # Errors
    ///
    /// [`PathError`], as [`PathView::with_yaw`].
    pub fn with_yaw(
        self,
        yaw: Option<&[f64]>,
        curvature: Option<&[f64]>,
    ) -> Result<Self, PathError> {
        let is_spline = yaw.is_none() && curvature.is_none();
        let kept = [yaw, curvature].map(|column| column.and_then(|column| self.kept(column)));
        let [yaw, curvature] = [kept[0].as_deref().or(yaw), kept[1].as_deref().or(curvature)];
        let (yaw, curvature) = if let Some(yaw) = yaw {
            (yaw.into(), curvature.map(Into::into))
        } else {
            let (yaw, bends) = spline(&self.view());
            (yaw, Some(curvature.map_or(bends, Into::into)))
        };
        // A spline that swings through noise or round corners is no contradiction.
        if !is_spline {
            self.view().with_yaw(&yaw, curvature.as_deref())?;
        }
        Ok(Self {
            yaw: Some(yaw),
            curvature,
            is_spline,
            ..self
        })
    }

    /// Whether heading and curvature are those of the spline through the waypoints.
    #[must_use]
    pub fn is_spline(&self) -> bool {
        self.is_spline
    }

    /// The segments at whose ends the direction changes, in order.
    fn section_ends(&self) -> Option<Box<[usize]>> {
        self.reverse.as_ref()?;
        let view = self.view();
        let ends = (0..view.segments()).filter(|&index| view.ends_at_cusp(index));
        Some(ends.collect())
    }

    /// The path as the controllers take it.
    #[inline]
    pub fn view(&self) -> PathView<'_> {
        PathView {
            x: &self.x,
            y: &self.y,
            s: &self.s,
            speed: self.speed.as_deref(),
            reverse: self.reverse.as_deref(),
            grade: self.grade.as_deref(),
            yaw: self.yaw.as_deref(),
            curvature: self.curvature.as_deref(),
            measures: self.measures,
            closed: self.closed,
            index: self.index.as_deref(),
            ends: self.ends.as_deref(),
        }
    }
}

/// For each segment, by the speeds at its ends, whether it is driven backwards.
fn reverse_by_speed(speed: &[f64], closed: bool) -> Box<[bool]> {
    let first = speed.first().copied().filter(|_| closed).unwrap_or(0.0);
    let ends = speed.iter().copied().skip(1).chain([first]);
    let mut before = false;
    let reverse = speed.iter().zip(ends).map(|(&start, end)| {
        let mut moving = [start, end].into_iter().filter(|speed| speed.abs() > 0.0);
        before = moving.next().map_or(before, |speed| speed < 0.0);
        before
    });
    reverse.collect()
}

/// The entries of a column at these places.
fn pick<T: Copy>(column: &[T], kept: &[usize]) -> Vec<T> {
    let entries = kept.iter().filter_map(|&index| column.get(index));
    entries.copied().collect()
}
