//! What comes from sensors may be anything: what is made of it stays within its bounds.

mod rig;

use proptest::prelude::*;
use rig::{HALF, PERIOD, modulation, motor};
use servo::feedback::commutation::Step as Search;
use servo::feedback::{Absolute, Commutation, Hall, Observer};
use servo::modulation::shares;
use servo::tuning::{Seen, Setup, Step, Tuning};
use servo::{Angle, Wiring};
use servo_plant::axes::SERVO_100W;
use servo_plant::{Gates, Plant};

fn any_number() -> impl Strategy<Value = f32> {
    prop_oneof![
        any::<u32>().prop_map(f32::from_bits),
        -20.0..20.0_f32,
        Just(f32::NAN)
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// While a motor is measured its sensors say anything for a while: widths are widths, it ends, and what it has found is a motor or none.
    #[test]
    fn a_measurement_bears_what_sensors_say(
        begin in 0..60_000_u32,
        wrong in prop::collection::vec((prop::option::of(prop::array::uniform3(any_number())), prop::option::of(any_number()), prop::option::of(any::<u16>())), 1..40),
    ) {
        let trip = 12.0;
        let setup = Setup {
            wiring: Wiring::ThreePhase,
            counts: 10_000,
            period: PERIOD,
            current: 4.0,
            trip,
            bus: (30.0, 60.0),
            modulation: modulation(&SERVO_100W, Wiring::ThreePhase),
            distance: 0.5,
            max_speed: 300.0,
        };
        let mut tuning = Tuning::new(setup).unwrap();
        let mut plant = Plant::new(SERVO_100W, 1);
        let mut wrong = wrong.into_iter();
        // As in the property of the current loop: what a sensor does not show the bus drives until the next sample acts, for each that is wrong.
        let beyond = 1.5 * f64::from(PERIOD) * (48.0 * 2.0 / 3.0 + 48.0) / 0.8e-3 * (1 + wrong.len()) as f64;
        for period in 0..400_000_u32 {
            prop_assert!(period < 399_999, "it does not end");
            let readings = plant.measure();
            let mut seen = Seen {
                currents: readings.currents.map(|current| current as f32),
                bus: readings.bus_voltage as f32,
                timer: readings.count as u16,
            };
            if period >= begin && let Some((currents, bus, timer)) = wrong.next() {
                seen.currents = currents.unwrap_or(seen.currents);
                seen.bus = bus.unwrap_or(seen.bus);
                seen.timer = timer.unwrap_or(seen.timer);
            }
            match tuning.run(&seen) {
                Step::Widths(widths) => {
                    for width in widths {
                        prop_assert!(width.unsigned_abs() <= 31_458, "{}", width);
                    }
                    plant.run(HALF);
                    plant.gates = Gates::On(shares(Wiring::ThreePhase, widths).map(f64::from));
                    plant.run(HALF);
                }
                Step::Failed(_) => break,
                Step::Done(found) => {
                    let numbers = [found.resistance, found.inductance_d, found.inductance_q, found.flux, found.inertia, found.friction];
                    prop_assert!(numbers.iter().all(|number| number.is_finite()), "{:?}", found);
                    break;
                }
            }
            for current in plant.phase_currents() {
                prop_assert!(current.abs() <= f64::from(trip) + beyond, "{} A", current);
            }
        }
    }
}

proptest! {
    /// Any words, angles, positions and speeds: angles go on, speeds are numbers, and the current of the search is its own.
    #[test]
    fn what_tells_where_the_magnet_is_bears_any_input(
        bits in 12..=20_u8,
        looks in prop::collection::vec((any::<u32>(), any::<u8>(), any::<u32>(), any::<i64>(), any_number()), 1..200),
    ) {
        let known = motor(&SERVO_100W, 4.0, 12.0);
        let mut absolute = Absolute::new(&known, bits, Angle::from_turns(0.01)).unwrap();
        let mut hall = Hall::default();
        let mut observer = Observer::new(3_000.0, PERIOD).unwrap();
        let mut search = Some(Commutation::new(&known, 4.0, PERIOD).unwrap());
        for (word, says, angle, position, speed) in looks {
            let before = absolute.position();
            if absolute.look(word).is_err() {
                prop_assert_eq!(absolute.position(), before, "a jump is not counted");
                absolute.resume(word);
            }
            let angle = Angle::from_bits(angle);
            let is_none = !(1..=6).contains(&says);
            prop_assert!(!is_none || hall.look(says, angle).is_err());
            let _ = hall.look(says & 7, angle);
            observer.look(angle);
            prop_assert!(observer.speed().is_finite() && observer.acceleration().is_finite());
            match search.as_mut().map(|search| search.run(position, speed)) {
                Some(Search::Hold { current, .. }) => prop_assert!((0.0..=4.0).contains(&current), "{}", current),
                _ => search = None,
            }
        }
    }
}
