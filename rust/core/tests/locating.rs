//! Where a vehicle is on a path, against the definition written out: every segment of the stretch,
//! its distance, and the direction of the path about it.

use popsteer_core::path::Follow;
use popsteer_core::path::locate::{locate, locate_by_scan};
use popsteer_core::path::projection::ClosestPoint;
use popsteer_core::{Path, Point, Vehicle, VehicleState};

/// What a path that leads opposite to the heading costs [m]; its direction is smoothed over 2 m.
const OPPOSITE: f64 = 10.0;

/// A path of short segments that crosses itself, with waypoints that are off by centimetres.
struct Coil {
    points: Vec<Point>,
    closed: bool,
}

impl Coil {
    fn open() -> Self {
        let point = |k: u32| {
            let s = 0.1 * f64::from(k);
            let angle = 3.0 * (0.11 * s).sin();
            let noise = 0.02 * f64::from(k * k).sin();
            Point::new(
                50.0 + 0.2 * s + (5.0 + noise) * angle.cos(),
                -30.0 + (5.0 + noise) * angle.sin(),
            )
        };
        Self {
            points: (0..900).map(point).collect(),
            closed: false,
        }
    }

    /// A figure of eight of some 30 m.
    fn closed() -> Self {
        let point = |k: u32| {
            let angle = f64::from(k) * std::f64::consts::TAU / 300.0;
            let noise = 0.02 * f64::from(k * k).sin();
            Point::new(
                (5.0 + noise) * angle.sin(),
                7.0 + 2.5 * (2.0 * angle).sin() + noise,
            )
        };
        Self {
            points: (0..300).map(point).collect(),
            closed: true,
        }
    }

    fn path(&self) -> Path {
        let (x, y): (Vec<f64>, Vec<f64>) = self.points.iter().map(|p| (p.x, p.y)).unzip();
        Path::new(&x, &y, None, self.closed).unwrap()
    }

    fn segments(&self) -> usize {
        self.points.len() - usize::from(!self.closed)
    }

    fn ends(&self, segment: usize) -> (Point, Point) {
        let next = (segment + 1) % self.points.len();
        (self.points[segment], self.points[next])
    }

    fn length(&self, segment: usize) -> f64 {
        let (from, to) = self.ends(segment);
        (to.x - from.x).hypot(to.y - from.y)
    }

    /// The place so far [m] from the start of a segment, along the path either way.
    fn place(&self, mut segment: usize, mut along: f64) -> Point {
        let count = self.segments();
        while along < 0.0 && (self.closed || segment > 0) {
            segment = (segment + count - 1) % count;
            along += self.length(segment);
        }
        while along > self.length(segment) && (self.closed || segment + 1 < count) {
            along -= self.length(segment);
            segment = (segment + 1) % count;
        }
        let (from, to) = self.ends(segment);
        let share = along / self.length(segment);
        Point::new(
            from.x + share * (to.x - from.x),
            from.y + share * (to.y - from.y),
        )
    }

    /// Share of the segment at its closest point, and the distance to that.
    fn nearest(&self, segment: usize, position: Point) -> (f64, f64) {
        let (from, to) = self.ends(segment);
        let (x, y) = (to.x - from.x, to.y - from.y);
        let share = ((position.x - from.x) * x + (position.y - from.y) * y) / (x * x + y * y);
        // The ends of an open path go on.
        let first = !self.closed && segment == 0;
        let last = !self.closed && segment + 1 == self.segments();
        let share = share
            .max(if first { f64::NEG_INFINITY } else { 0.0 })
            .min(if last { f64::INFINITY } else { 1.0 });
        let (x, y) = (from.x + share * x, from.y + share * y);
        (share, (position.x - x).hypot(position.y - y))
    }

    /// `distance + opposite (1 - cos d) / 2`, by the segment and by the chord of 2 m about the
    /// closest point; the lesser.
    fn cost(&self, segment: usize, position: Point, heading: Point) -> f64 {
        let (share, distance) = self.nearest(segment, position);
        let at = share * self.length(segment);
        let chord = (self.place(segment, at - 1.0), self.place(segment, at + 1.0));
        let costs = [self.ends(segment), chord].map(|(from, to)| {
            let (x, y) = (to.x - from.x, to.y - from.y);
            let cosine = (x * heading.x + y * heading.y) / x.hypot(y);
            distance + 0.5 * OPPOSITE * (1.0 - cosine)
        });
        costs[0].min(costs[1])
    }

    /// The stretch about a segment, in order: whole segments until they exceed `reach` behind and
    /// ahead; once around at most.
    fn stretch(&self, segment: usize, reach: f64) -> Vec<usize> {
        let count = self.segments();
        let mut all = vec![segment];
        let mut behind = 0.0;
        while behind <= reach && all.len() < count && (self.closed || all[0] > 0) {
            let previous = (all[0] + count - 1) % count;
            behind += self.length(previous);
            all.insert(0, previous);
        }
        let mut ahead = 0.0;
        let last = |all: &[usize]| all[all.len() - 1];
        while ahead <= reach && all.len() < count && (self.closed || last(&all) + 1 < count) {
            let next = (last(&all) + 1) % count;
            ahead += self.length(next);
            all.push(next);
        }
        all
    }

    fn located(&self, segment: usize, position: Point, heading: Point, reach: f64) -> usize {
        let stretch = self.stretch(segment, reach);
        let distances: Vec<f64> = stretch
            .iter()
            .map(|&k| self.nearest(k, position).1)
            .collect();
        let at = |k: Option<usize>| k.and_then(|k| distances.get(k)).copied();
        let minima = (0..stretch.len()).filter(|&k| {
            let before = at(k.checked_sub(1)).unwrap_or(f64::INFINITY);
            let after = at(Some(k + 1)).unwrap_or(f64::INFINITY);
            distances[k] <= before && distances[k] < after
        });
        let cost = |&k: &usize| self.cost(stretch[k], position, heading);
        let best = minima.min_by(|a, b| cost(a).total_cmp(&cost(b)));
        stretch[best.unwrap()]
    }
}

#[test]
fn test_vehicle_is_located_where_the_definition_has_it() {
    for coil in [Coil::open(), Coil::closed()] {
        let path = coil.path();
        let view = path.view();
        let (mut smoothed, mut elsewhere) = (0, 0);
        for k in 0..400_u32 {
            let wave = |rate: f64| (rate * f64::from(k) + 0.5).sin();
            let middle = 0.5 * f64::from(u32::try_from(coil.segments()).unwrap());
            let last = popsteer_core::math::to_count(middle * (1.0 + 0.99 * wave(1.7)));
            let near = coil.points[last];
            let position = Point::new(near.x + 2.0 * wave(2.3), near.y + 2.0 * wave(3.1));
            let yaw = 3.2 * wave(0.9);
            let heading = Point::new(yaw.cos(), yaw.sin());
            let reach = [1.0, 6.0, 12.0, 60.0][usize::try_from(k % 4).unwrap()];
            let expected = coil.located(last, position, heading, reach);
            let found = locate_by_scan(&view, last, position, heading, reach, OPPOSITE);
            assert_eq!(found.segment, expected, "{k} from {last} within {reach}");
            let (_, distance) = coil.nearest(expected, position);
            assert!((found.squared_distance.sqrt() - distance).abs() < 1e-9);
            let quick = locate(&view, last, position, heading, reach, OPPOSITE);
            assert_eq!(quick, found);
            elsewhere += usize::from(expected.abs_diff(last) > 30);
            smoothed += 1;
        }
        assert!(smoothed == 400 && elsewhere > 50, "{elsewhere}");
    }
}

#[test]
fn test_nearest_waypoint_is_the_nearer_end_and_the_start_where_both_are_as_near() {
    let path = Path::new(&[0.0, 1.0, 3.0, 7.0], &[0.0; 4], None, false).unwrap();
    let view = path.view();
    for (x, segment, nearest) in [
        (0.2, 0, 0),
        (0.8, 0, 1),
        (2.0, 1, 1),
        (2.5, 1, 2),
        (4.9, 2, 2),
        (6.0, 2, 3),
    ] {
        let closest = ClosestPoint::new(&view, segment, Point::new(x, 1.0));
        assert_eq!(closest.nearest_waypoint(&view), nearest, "{x}");
    }
}

/// One waypoint that lies back, and a recorded standstill within 2 cm: the vehicle is on the side of the
/// path about them, and so is its direction.
#[test]
fn test_vehicle_beside_jitter_is_on_the_side_of_the_path_about_it() {
    let back = vec![(20.0, -0.003), (19.99, 0.0)];
    let standstill = vec![(20.0, 0.01), (19.98, -0.02), (20.01, -0.01), (19.99, 0.02)];
    for jitter in [back, standstill] {
        let straight = |from: u32, to: u32| (from..to).map(|k| (f64::from(k), 0.0));
        let points = straight(0, 20).chain(jitter).chain(straight(21, 40));
        let (x, y): (Vec<f64>, Vec<f64>) = points.unzip();
        let plain = Path::new(&x, &y, None, false).unwrap();
        let own = plain.clone().with_yaw(Some(&vec![0.0; x.len()]), None);
        let mut back = 0;
        for path in [plain, own.unwrap()] {
            let poses = (0..200)
                .flat_map(|k| [-0.4, 0.0, 0.4].map(|yaw| (19.0 + 0.01 * f64::from(k), yaw)));
            for (x, yaw) in poses {
                for y in [-1.0, -0.2, 0.2, 1.0] {
                    let vehicle = VehicleState {
                        x,
                        y,
                        yaw,
                        speed: 1.0,
                    };
                    let follow = Follow::of(&Vehicle::PAPER, 0.0, 0.0);
                    let at = follow.locate(&path.view(), Some(19), vehicle, 0.05).closest;
                    assert!(at.cross_track_error() * y > 0.0, "{x} {yaw} {at:?}");
                    assert!(at.path_yaw().abs() < 1.6, "{x} {yaw} {at:?}");
                    let (start, end) = path.view().segment(at.segment);
                    back += usize::from(end.x < start.x);
                }
            }
        }
        assert!(back > 5, "{back}");
    }
}

/// What is offset from a place is found on the same lap and leg, farther off than a search goes.
#[test]
fn test_offset_from_a_place_goes_over_the_seam_and_not_over_a_cusp() {
    let car = Vehicle {
        wheelbase: 1.0,
        ..Vehicle::DEFAULT
    };
    let follow = Follow::of(&car, 0.0, 0.0);
    let pose = |x: f64, y: f64, yaw: f64| VehicleState {
        x,
        y,
        yaw,
        speed: 1.0,
    };
    // A lap of 80 m that begins in the midst of a side, at the origin.
    let sides: [(f64, f64); 5] = [
        (0.0, 0.0),
        (10.0, 0.0),
        (10.0, 20.0),
        (-10.0, 20.0),
        (-10.0, 0.0),
    ];
    let (mut x, mut y) = (Vec::new(), Vec::new());
    for (k, from) in sides.iter().enumerate() {
        let to = sides[(k + 1) % sides.len()];
        let length = (to.0 - from.0).hypot(to.1 - from.1);
        for step in 0..popsteer_core::math::to_count(length) {
            let share = popsteer_core::math::from_count(step) / length;
            x.push(from.0 + share * (to.0 - from.0));
            y.push(from.1 + share * (to.1 - from.1));
        }
    }
    let lap = Path::new(&x, &y, None, true).unwrap();
    let view = lap.view();
    for (from, to, arc) in [(2.0, -7.5, 72.5), (-2.0, 7.5, 7.5), (1.0, 8.5, 8.5)] {
        let here = follow.locate(&view, None, pose(from, 0.0, 0.0), 0.1);
        let there = follow.offset(&view, &here, pose(to, 0.0, 0.0), 0.0);
        let found = there.closest.arc_length(&view);
        assert!((found - arc).abs() < 1e-9, "{from} {to}: {found}");
    }
    // 20 m out and back on one line: beyond its end a leg goes on straight.
    let x: Vec<f64> = (0..=40)
        .map(|k| 20.0 - f64::from((k - 20_i32).abs()))
        .collect();
    let back: Vec<bool> = (0..=40).map(|k| k >= 20).collect();
    let legs = Path::new(&x, &[0.0; 41], None, false).unwrap();
    let legs = legs.with_reverse(&back).unwrap();
    let view = legs.view();
    for (waypoint, from, to, segment) in [
        (15, 15.0, 28.0, 19),
        (25, 15.0, 28.0, 20),
        (15, 15.0, 4.5, 4),
        (25, 15.0, 4.5, 35),
    ] {
        let here = follow.locate(&view, Some(waypoint), pose(from, 0.0, 0.0), 0.1);
        let there = follow.offset(&view, &here, pose(to, 0.0, 0.0), 0.0);
        assert_eq!(there.closest.segment, segment, "{waypoint} {to}");
        assert_eq!(there.reverse, waypoint == 25);
    }
}

/// After a jump of the localisation the last place explains what the jump explains, no more than the
/// heading costs: two lanes, and a pose so far from either.
#[test]
fn test_place_after_a_jump_is_the_other_lane_only_where_the_jump_does_not_explain_it() {
    use popsteer_core::path::{Place, Spot};
    let follow = Follow::of(&Vehicle::PAPER, 0.0, 0.0);
    for (apart, along, off, moves) in [
        (40.0, 60.0, 40.0, true), // on the other lane, 40 m from its own: 10 m are explained
        (8.0, 60.0, 8.0, false),  // 8 m from its own, by a jump of 60 m
        (8.0, 1.0, 8.0, false),   // by one of 8 m
        (8.0, 1.0, 3.0, false),   // nearer to its own
        (25.0, 80.0, 18.0, true), // 18 m from its own and 7 from the other: 11 more than 10
        (25.0, 80.0, 16.0, false), // 16 and 9
    ] {
        // Down one lane, and far round to the other one.
        let lane = (0..200).map(|k| (f64::from(k), 0.0));
        let round = [
            (400.0, 0.0),
            (400.0, -400.0),
            (-200.0, -400.0),
            (-200.0, apart),
        ];
        let other = (0..200).map(|k| (f64::from(k), apart));
        let (x, y): (Vec<f64>, Vec<f64>) = lane.chain(round).chain(other).unzip();
        let path = Path::new(&x, &y, None, false).unwrap();
        let view = path.view();
        let point = Point::new(20.0, 0.0);
        let place = Place::Lost(Spot { segment: 20, point });
        let vehicle = VehicleState {
            x: 20.0 + along,
            y: off,
            yaw: 0.0,
            speed: 1.0,
        };
        let at = follow.find(&view, &place, vehicle, 0.1, 0.1);
        let found = at.closest.point.y;
        assert!(
            (found - if moves { apart } else { 0.0 }).abs() < 1e-9,
            "{apart} {off}: {found}"
        );
    }
}

/// A vehicle that braked hard in a long period went as far as its speed before it: on the second of three
/// laps it is found there, neither short of it nor a lap off.
#[test]
fn test_vehicle_that_braked_in_a_long_period_is_found_as_far_as_it_went() {
    use popsteer_core::laws::{Stanley, StanleyParams};
    use popsteer_core::{Reported, Tracker};
    let angle = |arc: f64| arc / 40.0;
    let (x, y): (Vec<f64>, Vec<f64>) = (0..754)
        .map(|k| angle(f64::from(k)))
        .map(|a| (40.0 * a.sin(), 40.0 * (1.0 - a.cos())))
        .unzip();
    let path = Path::new(&x, &y, None, false).unwrap();
    let at = |arc: f64, speed: f64| VehicleState {
        x: 40.0 * angle(arc).sin(),
        y: 40.0 * (1.0 - angle(arc).cos()),
        yaw: angle(arc),
        speed,
    };
    let tracker = Tracker::of(Stanley::new(Vehicle::PAPER, StanleyParams::DEFAULT).unwrap());
    for (before, after, travelled) in [(36.0, 0.0, 18.0), (0.0, 36.0, 18.0), (18.0, 18.0, 18.0)] {
        let mut state = tracker.initial_state();
        let mut arc = 5.0;
        while arc < 300.0 {
            arc += 0.1 * before + 0.01;
            tracker
                .step(
                    &path.view(),
                    &mut state,
                    at(arc, before),
                    0.1,
                    Reported::NOTHING,
                )
                .unwrap();
        }
        let from = state.place.segment().unwrap();
        tracker
            .step(
                &path.view(),
                &mut state,
                at(arc + travelled, after),
                1.0,
                Reported::NOTHING,
            )
            .unwrap();
        let gone = state.place.segment().unwrap() - from;
        assert!((17..=19).contains(&gone), "{before} {after}: {gone}");
    }
}
