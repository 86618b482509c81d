use super::*;

pub(in super::super) const TWO: OverSpeed<'static> = OverSpeed {
    speeds: &[0.0],
    values: &[2.0],
};
pub(in super::super) const LIMITS: SpeedLimits<'static> = SpeedLimits {
    max_speed: 20.0,
    max_lateral_acceleration: 4.0,
    acceleration: TWO,
    deceleration: TWO,
    longitudinal_grip: None,
    exponent: 2.0,
    vehicle: Vehicle::DEFAULT,
};

pub(in super::super) fn level<'a>(table: &'a OverSpeed<'a>) -> Over<'a> {
    Over {
        table,
        lost: 0.0,
        most: f64::INFINITY,
    }
}

#[test]
fn test_bad_limit_is_named() {
    let falling = OverSpeed {
        speeds: &[0.0, 5.0, 5.0],
        values: &[1.0; 3],
    };
    let bad = [
        (
            SpeedLimits {
                max_speed: 0.0,
                ..LIMITS
            },
            "max_speed",
        ),
        (
            SpeedLimits {
                exponent: 0.5,
                ..LIMITS
            },
            "exponent",
        ),
        (
            SpeedLimits {
                acceleration: falling,
                ..LIMITS
            },
            "max_acceleration",
        ),
        (
            SpeedLimits {
                longitudinal_grip: Some(f64::NAN),
                ..LIMITS
            },
            "longitudinal_grip",
        ),
    ];
    for (limits, field) in bad {
        assert_eq!(limits.checked().unwrap_err().field, field);
    }
}
