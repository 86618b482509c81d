//! The path that owns its waypoints.

use alloc::boxed::Box;
use alloc::vec;
use alloc::vec::Vec;

use super::boxes::{self, Bounds};
use super::measure::{COINCIDING, Measures, check_column, measure};
use super::shape::spline;
use super::view::PathView;
use crate::bounds::MAX_SPEED;
use crate::error::PathError;
use crate::geometry::{Point, get_distance};

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
}

impl Path {
    /// Copies waypoints `x`, `y` [m] and reference speeds [m/s]; `closed` leads the last
    /// waypoint back to the first.
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
        let mut s = vec![0.0; x.len()].into_boxed_slice();
        let measures = measure(x, y, speed, closed, &mut s)?;
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

/// The waypoints to keep so that no two neighbours coincide: of several at one place the last,
/// whose speed and direction are those of what follows. A closed path that comes back to its
/// start also loses the repetition.
#[must_use]
pub fn distinct_waypoints(x: &[f64], y: &[f64], closed: bool) -> Vec<usize> {
    let points = || x.iter().zip(y).map(|(&x, &y)| Point::new(x, y));
    let mut kept: Vec<(usize, Point)> = Vec::new();
    for (index, point) in points().enumerate() {
        while let Some((_, last)) = kept.last()
            && get_distance(*last, point) <= COINCIDING
        {
            kept.pop();
        }
        kept.push((index, point));
    }
    if closed {
        while let [(_, first), .., (_, last)] = kept.as_slice()
            && get_distance(*first, *last) <= COINCIDING
        {
            kept.pop();
        }
    }
    kept.into_iter().map(|(index, _)| index).collect()
}
