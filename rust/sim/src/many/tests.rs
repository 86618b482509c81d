use super::*;
use crate::noise::Noise;
use crate::plant::CarlaIdentified;
use popsteer_core::laws::{Pop, PopParams};

fn runs(count: u32, noise: Noise, seed: u64) -> Vec<Run> {
    let x: Vec<f64> = (0..300).map(f64::from).collect();
    let y: Vec<f64> = x.iter().map(|x| 5.0 * (x / 20.0).sin()).collect();
    let path = Arc::new(Path::new(&x, &y, None, false).unwrap());
    let plant = CarlaIdentified::default();
    let pop = Pop::new(plant.vehicle, PopParams::default()).unwrap();
    let law = Tracker::of(Law::from(pop));
    let plant: Arc<dyn Plant> = Arc::new(plant);
    let start = |k| VehicleState {
        x: 0.0,
        y: 0.1 * f64::from(k),
        yaw: 0.2,
        speed: 5.0,
    };
    (0..count)
        .map(|k| Run {
            law,
            path: Arc::clone(&path),
            plant: Arc::clone(&plant),
            start: start(k),
            perception: Perception::new(noise, seed, u64::from(k)),
            longitudinal: Longitudinal::default(),
        })
        .collect()
}

#[test]
fn test_runs_same_seed_same_bits_on_any_number_of_threads() {
    let noise = Noise {
        position: 0.1,
        yaw: 0.005,
        speed: 0.1,
    };
    let on = |threads, seed| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        let settings = Settings::default();
        let watch = Watch::default();
        pool.install(|| run_many(&runs(20, noise, seed), settings, &watch))
            .unwrap()
    };
    let one = on(1, 7);
    assert!(one.iter().all(|metrics| metrics.finished));
    assert_eq!(one, on(3, 7));
    assert_ne!(one, on(1, 8));
    let errors: Vec<f64> = one
        .iter()
        .map(|m| m.reference.cross_track.mean_abs)
        .collect();
    assert!(
        errors
            .windows(2)
            .all(|pair| (pair[0] - pair[1]).abs() > 0.0)
    );
}

#[test]
fn test_runs_without_noise_are_single_runs() {
    let settings = Settings::default();
    let watch = Watch::default();
    let many = run_many(&runs(3, Noise::DEFAULT, 0), settings, &watch).unwrap();
    assert_eq!(watch.done(), 3);
    for (run, metrics) in runs(3, Noise::DEFAULT, 0).into_iter().zip(many) {
        let tracked = *run.law.follow();
        let mut simulation =
            Simulation::new(run.path, run.plant, run.start, tracked, settings).unwrap();
        let mut controller = Controller::new(&run.law);
        let exact = Perception::EXACT;
        let longitudinal = &run.longitudinal;
        closed_loop::run(
            &mut simulation,
            &mut controller,
            longitudinal,
            exact,
            |_| true,
        )
        .unwrap();
        assert_eq!(simulation.metrics(), metrics);
    }
}

#[test]
fn test_runs_stopped_do_not_finish() {
    let watch = Watch::default();
    watch.stop();
    let settings = Settings::default();
    let many = run_many(&runs(3, Noise::DEFAULT, 0), settings, &watch).unwrap();
    assert!(
        many.iter()
            .all(|metrics| !metrics.finished && metrics.steps == 0)
    );
}
