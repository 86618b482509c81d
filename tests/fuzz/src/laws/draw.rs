//! Parts of a tracker's state, within their bounds.

use crate::bytes::Bytes;
use crate::scene::symmetric;
use popsteer_core::Point;
use popsteer_core::lateral::{Deviation, MonitorState};
use popsteer_core::limits::{MAX_COORDINATE, MAX_YAW};

pub(super) fn draw_monitor(bytes: &mut Bytes) -> Option<MonitorState> {
    if bytes.byte() < 150 {
        return None;
    }
    let unknown = |bytes: &mut Bytes| bytes.byte() & 1 == 1;
    let most: f64 = [1.0, 1e100][bytes.below(2)];
    Some(MonitorState {
        wheel: symmetric(bytes, 1.0, 1.57),
        yaw: unknown(bytes).then(|| symmetric(bytes, 4.0, MAX_YAW)),
        residual: unknown(bytes).then(|| symmetric(bytes, 0.1, most.min(1e49))),
        measured: symmetric(bytes, 0.5, most),
        expected: symmetric(bytes, 0.5, most),
        delayed: symmetric(bytes, 0.5, most),
        rate: symmetric(bytes, 0.5, most),
        reach: symmetric(bytes, 3.0, most),
        excess: symmetric(bytes, 0.1, most).abs(),
        time: bytes.within(0.0, MonitorState::NOISE_TIME),
        noise: symmetric(bytes, 1e-4, most).abs(),
        offset_square: symmetric(bytes, 10.0, most).abs(),
        offset_sum: symmetric(bytes, 1.0, most),
        alarm: bytes.within(0.0, MonitorState::ALARM_TIME),
        within: bytes.byte() & 1 == 1,
    })
}

pub(super) fn draw_deviation(bytes: &mut Bytes) -> Deviation {
    Deviation {
        cross_track_error: symmetric(bytes, 2.0, 4.0 * MAX_COORDINATE),
        yaw: symmetric(bytes, 4.0, 2.0 * MAX_YAW),
        along: Point::new(
            symmetric(bytes, 2.0, 4.0 * MAX_COORDINATE),
            symmetric(bytes, 2.0, 4.0 * MAX_COORDINATE),
        ),
    }
}
