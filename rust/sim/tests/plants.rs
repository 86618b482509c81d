//! The plants do what their equations say, by hand.

use popsteer_core::{Vehicle, VehicleState};
use popsteer_sim::delay::Delay;
use popsteer_sim::plant::{CarlaIdentified, KinematicBicycle, NAMES, PedalMap, by_name};
use popsteer_sim::{Control, Plant, PlantState};

const ROLLING: VehicleState = VehicleState {
    x: 3.0,
    y: -2.0,
    yaw: 0.7,
    speed: 12.0,
};

fn close(number: f64, expected: f64) -> bool {
    (number - expected).abs() <= 1e-12 * expected.abs().max(1.0)
}

fn moved(plant: &dyn Plant, state: PlantState, control: Control, dt: f64) -> PlantState {
    let mut state = state;
    plant.advance(&mut state, control, dt, 1);
    state
}

#[test]
fn test_identified_plant_steps_by_its_equations() {
    let plant = CarlaIdentified::DEFAULT;
    let before = PlantState {
        vehicle: ROLLING,
        yaw_rate: -0.25,
        wheel: 0.0,
        road_wheel: 0.0,
        throttle: 0.4,
    };
    let control = Control {
        steer: 0.1,
        throttle: 0.9,
        brake: 0.2,
        reverse: false,
    };
    let dt = 0.004;
    let after = moved(&plant, before, control, dt);

    let steady = 12.0 * 0.1_f64.tan() / (3.553 + 2.9e-4 * 144.0);
    let drags = 0.28 * 12.0 + 0.001 * 144.0 + 0.11 * 0.25 * 12.0;
    let acceleration = 6.0 * 0.4 - drags - 9.0 * 0.2;
    let vehicle = after.vehicle;
    assert!(close(vehicle.x, 3.0 + dt * 12.0 * 0.7_f64.cos()));
    assert!(close(vehicle.y, -2.0 + dt * 12.0 * 0.7_f64.sin()));
    assert!(close(vehicle.yaw, 0.7 - dt * 0.25));
    assert!(close(vehicle.speed, 12.0 + dt * acceleration));
    assert!(close(after.yaw_rate, -0.25 + dt / 0.1 * (steady + 0.25)));
    assert!(close(after.throttle, 0.4 + dt * (0.9 - 0.4) / 0.25));

    // A step longer than the lag ends at the steady turn, not beyond it.
    assert!(close(moved(&plant, before, control, 0.2).yaw_rate, steady));
    // Brakes end at rest.
    let full = Control {
        brake: 1.0,
        ..control
    };
    assert!(moved(&plant, before, full, 5.0).vehicle.speed.abs() <= 0.0);
}

#[test]
fn test_identified_plant_moves_alike_whichever_point_its_pose_is_of() {
    let of = |rear_axle, vehicle: VehicleState| {
        let plant = CarlaIdentified {
            vehicle: Vehicle {
                rear_axle,
                no_slip_point: None,
                ..CarlaIdentified::VEHICLE
            },
            ..CarlaIdentified::DEFAULT
        };
        let mut state = PlantState::settled(&plant.vehicle, vehicle);
        let control = Control {
            steer: 0.2,
            throttle: 0.5,
            ..Control::default()
        };
        plant.advance(&mut state, control, 0.005, 200);
        state.vehicle
    };
    let rear = of(0.0, ROLLING);
    let front = of(-1.5, ROLLING.ahead(1.5)).ahead(-1.5);
    assert!((front.x - rear.x).abs() < 1e-9 && (front.y - rear.y).abs() < 1e-9);
    assert!((front.yaw - rear.yaw).abs() < 1e-12);
}

#[test]
fn test_bicycle_speeds_up_by_throttle_less_brake_and_drag() {
    let plant = KinematicBicycle::DEFAULT;
    let before = PlantState {
        vehicle: ROLLING,
        yaw_rate: 0.0,
        wheel: 0.0,
        road_wheel: 0.0,
        throttle: 0.5,
    };
    let control = Control {
        throttle: 0.5,
        brake: 0.1,
        ..Control::default()
    };
    let speed = moved(&plant, before, control, 0.01).vehicle.speed;
    assert!(close(
        speed,
        12.0 + 0.01 * (6.0 * 0.5 - 9.0 * 0.1 - 0.28 * 12.0)
    ));
}

#[test]
fn test_drive_of_a_bicycle_follows_its_pedal_behind_the_lag() {
    let plant = KinematicBicycle {
        vehicle: Vehicle {
            drive_lag: 0.4,
            ..KinematicBicycle::VEHICLE
        },
        ..KinematicBicycle::DEFAULT
    };
    let before = PlantState {
        throttle: 0.2,
        ..PlantState::settled(&plant.vehicle, ROLLING)
    };
    let control = Control {
        throttle: 0.8,
        ..Control::default()
    };
    let after = moved(&plant, before, control, 0.1);
    assert!(close(after.throttle, 0.8 - 0.6 * (-0.25_f64).exp()));
}

#[test]
fn test_offset_of_the_wheels_is_not_the_plants_to_add() {
    let driven = |steer_offset| {
        let vehicle = Vehicle {
            steer_offset,
            ..KinematicBicycle::VEHICLE
        };
        let bicycle = KinematicBicycle {
            vehicle,
            ..KinematicBicycle::DEFAULT
        };
        let identified = CarlaIdentified {
            vehicle,
            ..CarlaIdentified::DEFAULT
        };
        let state = PlantState::settled(&KinematicBicycle::VEHICLE, ROLLING);
        let control = Control {
            steer: 0.1,
            ..Control::default()
        };
        [
            moved(&bicycle, state, control, 0.01),
            moved(&identified, state, control, 0.01),
        ]
    };
    assert_eq!(driven(0.0), driven(0.07));
}

#[test]
fn test_pedals_undo_the_drive_the_brakes_and_the_drag() {
    let map = PedalMap {
        drive: 6.0,
        braking: 9.0,
        drag: 0.28,
        air_drag: 0.01,
    };
    for speed in [0.0, 5.0, 12.0, -6.0] {
        for wanted in [-4.0, -1.0, 0.0, 0.5] {
            let (throttle, brake) = map.of(wanted, speed);
            let drag = 0.28 * speed + 0.01 * speed * f64::abs(speed);
            assert!(close(6.0 * throttle - 9.0 * brake - drag, wanted));
            assert!(throttle == 0.0 || brake == 0.0);
        }
    }
    // The plants' own maps are those of their equations.
    for name in NAMES {
        let plant = by_name(name).unwrap();
        let (throttle, brake) = plant.pedals().unwrap().of(-1.5, 12.0);
        let before = PlantState {
            vehicle: ROLLING,
            yaw_rate: 0.0,
            wheel: 0.0,
            road_wheel: 0.0,
            throttle,
        };
        let control = Control {
            throttle,
            brake,
            ..Control::default()
        };
        let speed = moved(plant.as_ref(), before, control, 0.01).vehicle.speed;
        assert!(close(speed, 12.0 - 0.01 * 1.5), "{name}: {speed}");
    }
}

#[test]
fn test_plants_are_found_by_their_names_and_tell_what_they_are() {
    for name in NAMES {
        assert_eq!(by_name(name).unwrap().name(), name);
    }
    assert!(by_name("no-such-plant").is_none());
    let long = Vehicle {
        wheelbase: 4.0,
        ..KinematicBicycle::VEHICLE
    };
    let bicycle = KinematicBicycle {
        vehicle: long,
        ..KinematicBicycle::DEFAULT
    };
    assert_eq!(bicycle.checked(), Ok(bicycle));
    assert_eq!(*bicycle.vehicle(), long);
    assert_eq!(
        *CarlaIdentified::DEFAULT.vehicle(),
        CarlaIdentified::VEHICLE
    );
    assert!(bicycle.reverses() && !CarlaIdentified::DEFAULT.reverses());
}

/// Every command arrives, for as long as it was given: what has acted and what is in flight are
/// what was commanded.
#[test]
fn test_delay_passes_on_every_command_for_its_time() {
    let unit = 1.0 / 1024.0;
    let dead_time = 13.0 * unit;
    let mut delay = Delay::new(dead_time);
    let (mut given, mut acted, mut since) = (0.0, 0.0, 0.0);
    // Periods shorter and longer than the steps before them, in units; some end together.
    let periods = [
        (3, 1),
        (2, 2),
        (5, 1),
        (16, 1),
        (1, 7),
        (13, 1),
        (1, 1),
        (9, 3),
        (13, 2),
    ];
    for (k, &(length, substeps)) in periods.iter().cycle().take(60).enumerate() {
        let command = 0.1 + 0.01 * popsteer_core::math::from_count(k);
        let dt = f64::from(length) * unit;
        let mut steps = 0;
        delay.pass(command, dt, substeps, |angle, count| {
            acted += angle * dt * popsteer_core::math::from_count(count);
            steps += count;
        });
        assert_eq!(steps, substeps);
        given += command * dt * popsteer_core::math::from_count(substeps);
        since += dt * popsteer_core::math::from_count(substeps);
        let flying: f64 = delay.commands().map(|(angle, time)| angle * time).sum();
        assert!((acted + flying - given).abs() < 1e-12, "after {since} s");
    }
}

#[test]
fn test_play_lets_the_wheels_stand_until_the_steering_has_crossed_it() {
    let vehicle = Vehicle {
        steer_lag: 0.0,
        steer_play: 0.02,
        ..KinematicBicycle::VEHICLE
    };
    let car = KinematicBicycle {
        vehicle,
        ..KinematicBicycle::DEFAULT
    };
    let identified = CarlaIdentified {
        vehicle,
        ..CarlaIdentified::DEFAULT
    };
    for plant in [&car as &dyn Plant, &identified] {
        let mut state = PlantState::settled(plant.vehicle(), ROLLING);
        // There, into the play, back by less than it and by more.
        for (steer, wheel) in [
            (0.1, 0.09),
            (0.12, 0.11),
            (0.105, 0.11),
            (0.05, 0.06),
            (0.06, 0.06),
        ] {
            let control = Control {
                steer,
                ..Control::default()
            };
            plant.advance(&mut state, control, 0.004, 1);
            assert!(
                (state.road_wheel - wheel).abs() < 1e-15,
                "{}",
                state.road_wheel
            );
            assert_eq!(state.wheel.to_bits(), steer.to_bits());
        }
    }
}
