use super::*;
use crate::plant::KinematicBicycle;
use popsteer_core::Vehicle;

/// The path's speed, or what can still brake for the cusp at 50 m.
#[test]
fn test_stopping_speed_brakes_for_the_cusp_at_the_vehicles_deceleration() {
    let x: Vec<f64> = (0..100)
        .map(|k| f64::from(if k <= 50 { k } else { 100 - k }))
        .collect();
    let speed: Vec<f64> = (0..100).map(|k| if k < 50 { 9.0 } else { -9.0 }).collect();
    let cusp = Arc::new(Path::new(&x, &[0.0; 100], Some(&speed), false).unwrap());
    let forward = Arc::new(Path::new(&x[..50], &[0.0; 50], Some(&[9.0; 50]), false).unwrap());
    let at = |path: &Arc<Path>, x: f64, max_deceleration: Option<f64>| {
        let plant = KinematicBicycle {
            vehicle: Vehicle {
                max_deceleration,
                ..KinematicBicycle::VEHICLE
            },
            ..KinematicBicycle::DEFAULT
        };
        let start = VehicleState {
            x,
            y: 0.0,
            yaw: 0.0,
            speed: 5.0,
        };
        let follow = Follow::of(&plant.vehicle, 0.0, 0.0);
        let path = Arc::clone(path);
        let settings = Settings::DEFAULT;
        let run = Simulation::new(path, Arc::new(plant), start, follow, settings).unwrap();
        run.stopping_speed().unwrap()
    };
    for (x, deceleration, expected) in [
        (10.0, None, 9.0),
        (40.0, None, f64::sqrt(2.0 * 2.0 * 10.0)),
        (42.0, Some(0.5), f64::sqrt(2.0 * 0.5 * 8.0)),
    ] {
        let found = at(&cusp, x, deceleration);
        assert!((found - expected).abs() < 1e-9, "{found}, not {expected}");
    }
    assert!((at(&forward, 40.0, None) - 9.0).abs() < 1e-9);
}
