//! The link, and what comes before the loops. How the loops move a motor is tested in the plant (`sim`).

extern crate std;

use super::*;
use cia402::{ServoGoal, ServoOrder, ServoPort, ServoReport};
use motion::{PulseSink, Record, SignedSpeed, Speed};
use servo::control::Fault;
use servo::feedback::Commutation;
use servo::interrupt::Counts;
use servo::modulation::Widths;
use servo::{Angle, Motor, Wiring};
use std::boxed::Box;

/// That of the plant's axis, on a board with a converter of 12 bits.
pub(super) const DATA: ServoData = ServoData {
    motor: Motor {
        wiring: Wiring::ThreePhase,
        pole_pairs: 4,
        resistance: 0.6,
        inductance_d: 0.8e-3,
        inductance_q: 0.8e-3,
        flux: 13.33e-3,
        rated_current: 4.0,
        peak_current: 12.0,
        inertia: 9.6e-6,
        counts: 10_000,
    },
    friction: 0.0,
    bandwidth: 600.0,
    speed: 3_000,
    feedback: Feedback::Incremental,
    encoder: 0,
    stage: StageData {
        period: 50e-6,
        control: 5,
        voltage: 48.0,
        dead_time: 0.003,
        ripple: 0.2,
        reach: 0.9,
        current: 0.02,
        middle: (2_048, 100),
        bus: 0.0154,
        bears: (12.0, 2.0),
    },
};

/// No current flows, so none of account may be asked for: a phase that carries nothing is lost.
const AT_REST: Counts = Counts {
    currents: [2_048; 3],
    bus: 3_117,
    timer: 0,
};

fn held(torque: i32) -> ServoOrder {
    ServoOrder {
        goal: ServoGoal::Torque,
        torque,
        velocity_ahead: SignedSpeed::ZERO,
        max_torque: (u32::MAX, u32::MAX),
        current: u32::MAX,
        velocity: Speed::MAX,
    }
}

/// Both interrupts of a board, one behind the other.
struct Board {
    current: Current,
    linked: LinkedLoops,
}

fn linked(magnet: Option<Angle>) -> (Board, Port, &'static Link) {
    let link: &'static Link = Box::leak(Box::new(Link::new()));
    let board = Board {
        current: Current::new(&DATA, 0, magnet).unwrap(),
        linked: LinkedLoops::new(Loops::new(&DATA).unwrap(), link, 84_000_000),
    };
    (board, Port::new(link, 0, 0), link)
}

/// So many periods; the widths of the last.
fn run(board: &mut Board, periods: u32, counts: &Counts) -> Option<Widths> {
    let mut last = None;
    for _ in 0..periods {
        last = board.current.period(counts);
        if board.current.is_due() {
            let state = board.linked.run(&mut board.current, 0);
            board.linked.tell(&mut board.current, &state);
        }
        last = last.filter(|_| !board.current.is_off());
    }
    last
}

#[test]
fn the_sensors_are_learnt_first_and_then_the_magnet_is_looked_for() {
    let (mut board, _, link) = linked(None);
    assert_eq!(run(&mut board, 100, &AT_REST), None);
    link.energise(true);
    // Taken within five periods; 256 samples with the gates off.
    let off = Counts {
        currents: [2_060, 2_048, 2_036],
        ..AT_REST
    };
    assert_eq!(run(&mut board, 250, &off), None);
    assert!(link.status().report.wants_free);
    // Then the field rises, from widths that are equal: the offsets are no current.
    let widths = run(&mut board, 12, &off).unwrap();
    assert!(widths.iter().all(|width| width.abs() < 700), "{widths:?}");
    // A rotor that is held does not follow it.
    run(&mut board, 60_000, &off);
    assert_eq!(link.status().fault, Some(0x7305));
    link.energise(false);
    run(&mut board, 10, &AT_REST);
    assert_eq!(link.status().fault, None);
}

#[test]
fn a_sensor_far_from_its_middle_is_a_fault() {
    let (mut board, _, link) = linked(None);
    link.energise(true);
    let counts = Counts {
        currents: [2_300, 2_048, 2_048],
        ..AT_REST
    };
    assert_eq!(run(&mut board, 300, &counts), None);
    assert_eq!(link.status().fault, Some(0x7300));
}

#[test]
fn an_order_goes_over_the_link_and_a_report_comes_back() {
    let (mut board, mut port, link) = linked(Some(Angle::ZERO));
    link.energise(true);
    port.order(&held(4_000));
    run(&mut board, 40, &AT_REST);
    let status = link.status();
    assert_eq!(status.report.demand, 4_000);
    assert_eq!(status.millivolts, 48_001);
    assert!(run(&mut board, 1, &AT_REST).is_some());
    // What the board finds takes the current.
    link.set_stage(250, true);
    assert_eq!(run(&mut board, 10, &AT_REST), None);
}

#[test]
fn who_has_locked_a_part_is_not_waited_for() {
    let (mut board, mut port, link) = linked(Some(Angle::ZERO));
    link.energise(true);
    port.order(&held(4_000));
    run(&mut board, 10, &AT_REST);
    // The interrupt comes while the tick copies.
    link.while_locked(|| {
        let widths = run(&mut board, 10, &AT_REST);
        assert!(widths.is_some(), "{:?}", board.current.fault());
    });
    assert_eq!(link.status().report.demand, 4_000);
}

/// It is told once, and looked at again until it is taken over.
#[test]
fn a_motor_that_is_set_with_the_power_on_is_taken_over_once_it_is_off() {
    let (mut board, _, link) = linked(Some(Angle::ZERO));
    link.energise(true);
    run(&mut board, 10, &AT_REST);
    let settings = ServoSettings {
        motor: [700_000, 0, 0, 0, 0, 0],
        ..ServoSettings::NONE
    };
    link.set_up(settings, None);
    run(&mut board, 10, &AT_REST);
    assert_eq!(board.linked.loops.motor().resistance, 0.6);
    link.energise(false);
    run(&mut board, 10, &AT_REST);
    assert!((board.linked.loops.motor().resistance - 0.7).abs() < 1e-6);
}

#[test]
fn what_a_measurement_has_found_is_told_also_if_it_ends_at_once() {
    let (mut board, _, link) = linked(Some(Angle::ZERO));
    run(&mut board, 10, &AT_REST);
    let request = Request::Motor {
        current: 500,
        distance: 500,
        bandwidth: 0,
    };
    link.set_up(ServoSettings::NONE, Some(request));
    run(&mut board, 10, &AT_REST);
    let found = link.found();
    assert_eq!((found.state, found.failure), (7, 8), "no power");
    link.energise(true);
    run(&mut board, 10, &AT_REST);
    link.set_up(ServoSettings::NONE, Some(request));
    run(&mut board, 10, &AT_REST);
    assert_eq!(link.found().state, 1);
    link.energise(false);
    run(&mut board, 10, &AT_REST);
    let found = link.found();
    assert_eq!((found.state, found.failure), (7, 1), "the power went off");
}

#[test]
fn records_pass_in_time() {
    let (_, mut port, _) = linked(Some(Angle::ZERO));
    let record = Record {
        period: 1_000,
        repeat: 84,
        width: 8,
        direction: motion::Direction::Forward,
    };
    port.push(record).unwrap();
    assert_eq!(port.pending(), 84_000);
    port.pass(50_000);
    assert_eq!(port.pending(), 34_000);
    port.pass(100_000);
    assert_eq!(port.pending(), 0);
    port.push(record).unwrap();
    port.forget();
    assert_eq!(port.pending(), 0);
}

#[test]
fn an_edge_is_where_the_timer_was() {
    let link: &'static Link = Box::leak(Box::new(Link::new()));
    let port = Port::new(link, 0, 65_000);
    let report = ServoReport {
        counts: -700,
        ..ServoReport::NONE
    };
    let status = link::LoopStatus {
        report,
        ..link::LoopStatus::default()
    };
    link.publish(0, || status);
    assert_eq!(port.position(), -700);
    assert_eq!(port.position_at(64_310), -690);
    assert_eq!(port.position_at(64_290), -710);
}

#[test]
fn an_edge_is_where_the_timer_was_on_an_encoder_with_other_counts() {
    let link: &'static Link = Box::leak(Box::new(Link::new()));
    let port = Port::new(link, 0, 65_000).with_counts(4_000, 50_000);
    let report = ServoReport {
        counts: -700,
        ..ServoReport::NONE
    };
    let status = link::LoopStatus {
        report,
        ..link::LoopStatus::default()
    };
    link.publish(0, || status);
    // 56 counts below where it began.
    assert_eq!(port.position_at(64_944), -700);
    assert_eq!(port.position_at(64_954), -575);
    assert_eq!(port.position_at(64_934), -825);
}

/// What a product asks for comes over the link as the loops tell it, once somebody asks.
#[test]
fn the_report_of_the_loops_is_published_once_it_was_asked_for() {
    let (mut board, mut port, link) = linked(Some(Angle::QUARTER));
    link.energise(true);
    port.order(&held(4_000));
    run(&mut board, 40, &AT_REST);
    assert!(!link.loop_report(&DATA).is_on, "nobody has asked before");
    run(&mut board, 10, &AT_REST);
    let report = link.loop_report(&DATA);
    assert!(report.is_on);
    assert_eq!(report, board.linked.loops.loop_report(&mut board.current));
    assert_eq!((report.counts_of_turn, report.pole_pairs), (10_000, 4));
    assert_eq!(report.rated_current, 4_000);
    let settings = ServoSettings {
        pole_pairs: 7,
        ..ServoSettings::NONE
    };
    link.energise(false);
    link.set_up(settings, None);
    run(&mut board, 10, &AT_REST);
    let report = link.loop_report(&DATA);
    assert_eq!((report.pole_pairs, report.own_pole_pairs), (7, 4));
}

/// A host that counts how often the loops come to what the current interrupt has.
struct Counted<'a> {
    current: &'a mut Current,
    locks: usize,
}

impl CurrentLock for Counted<'_> {
    fn lock<R>(&mut self, f: impl FnOnce(&mut Current) -> R) -> R {
        self.locks += 1;
        f(self.current)
    }
}

#[test]
fn the_loops_are_due_in_one_of_five_periods_and_what_they_want_acts_from_the_next_one_on() {
    let (mut board, _, _) = linked(Some(Angle::ZERO));
    let mut loops = Loops::new(&DATA).unwrap();
    loops.energise(&mut board.current, true);
    loops.take(Some(held(4_000)));
    for period in 0..20 {
        assert!(board.current.period(&AT_REST).is_some());
        assert_eq!(board.current.is_due(), period % 5 == 0);
        assert_eq!(board.current.demand().q > 0.0, period > 0);
        if board.current.is_due() {
            let mut counted = Counted {
                current: &mut board.current,
                locks: 0,
            };
            loops.run(&mut counted, 0.0, 0, 250);
            assert_eq!(counted.locks, 2, "a copy up and one down");
        }
    }
}

#[test]
fn a_fault_of_the_loops_takes_the_current_before_the_next_period() {
    let (mut board, _, _) = linked(Some(Angle::ZERO));
    let mut loops = Loops::new(&DATA).unwrap();
    loops.energise(&mut board.current, true);
    assert!(board.current.period(&AT_REST).is_some());
    loops.run(&mut board.current, 0.0, 0, 250);
    assert!(!board.current.is_off());
    loops.run(&mut board.current, 0.0, 0, 1_200);
    assert!(board.current.is_off());
    assert_eq!(board.current.fault(), Some(Fault::Temperature));
    assert_eq!(board.current.period(&AT_REST), None);
}

#[test]
fn a_trip_of_the_current_is_told_by_the_loops() {
    let (mut board, _, link) = linked(Some(Angle::ZERO));
    link.energise(true);
    run(&mut board, 11, &AT_REST);
    let counts = Counts {
        bus: 4_000,
        ..AT_REST
    };
    assert_eq!(run(&mut board, 1, &counts), None);
    assert!(board.current.is_off(), "in the same period");
    run(&mut board, 5, &AT_REST);
    assert_eq!(link.status().fault, Some(0x3210));
    assert_eq!(run(&mut board, 5, &AT_REST), None);
}

/// The power came while the current was barred, so the sensors were not learnt and the magnet was not looked for.
#[test]
fn what_comes_before_the_loops_comes_too_where_the_current_was_barred_first() {
    let (mut board, _, link) = linked(None);
    let barred = ServoSettings {
        is_barred: true,
        ..ServoSettings::NONE
    };
    link.set_up(barred, None);
    link.energise(true);
    assert_eq!(run(&mut board, 300, &AT_REST), None);
    link.set_up(ServoSettings::NONE, None);
    assert_eq!(run(&mut board, 250, &AT_REST), None);
    assert!(link.status().report.wants_free, "it begins");
    assert!(run(&mut board, 20, &AT_REST).is_some(), "a field");
    link.set_up(barred, None);
    run(&mut board, 5, &AT_REST);
    assert_eq!(run(&mut board, 1, &AT_REST), None);
}

#[test]
fn the_magnet_is_looked_for_with_the_pole_pairs_that_are_set() {
    let (mut board, _, link) = linked(None);
    let settings = ServoSettings {
        pole_pairs: 7,
        ..ServoSettings::NONE
    };
    link.set_up(settings, None);
    run(&mut board, 10, &AT_REST);
    let motor = *board.linked.loops.motor();
    assert_eq!(motor.pole_pairs, 7);
    let search = Commutation::new(&motor, motor.rated_current, 50e-6).ok();
    assert_eq!(board.current.search, search);
}

/// The shares and the learning of the current loop, by whatever way they have come there.
#[test]
fn a_start_and_another_motor_keep_the_gains_of_the_current_loop() {
    let gains = ServoSettings {
        share: 500,
        share_along: 200,
        learning: 100,
        ..ServoSettings::default()
    };
    let all = ServoSettings {
        motor: [700_000, 0, 0, 0, 0, 0],
        ..gains
    };
    let of = |steps: &[ServoSettings]| {
        let mut current = Current::new(&DATA, 0, Some(Angle::ZERO)).unwrap();
        let mut loops = Loops::new(&DATA).unwrap();
        for settings in steps {
            loops.set_up(&mut current, settings);
        }
        (current, loops)
    };
    let motor = ServoSettings {
        motor: all.motor,
        ..ServoSettings::default()
    };
    let (before, _) = of(&[motor, all]);
    let (behind, mut loops) = of(&[gains, all]);
    assert_eq!(before.interrupt.current, behind.interrupt.current);
    let mut current = behind.clone();
    loops.energise(&mut current, true);
    current.period(&AT_REST);
    loops.energise(&mut current, false);
    loops.energise(&mut current, true);
    let mut anew = behind;
    anew.interrupt.current.start();
    let without = Current::new(&DATA, 0, Some(Angle::ZERO)).unwrap();
    let asks = |current: &Current| {
        let mut current = current.interrupt.current;
        let sample = servo::current_loop::Sample {
            bus: 48.0,
            ..Default::default()
        };
        current
            .run(&sample, servo::transform::Rotor { d: 1.0, q: 1.0 })
            .unwrap();
        current.voltage()
    };
    let [wanted, own] = [&before, &without].map(asks);
    assert!(
        wanted.d < 0.5 * own.d && wanted.q < 0.7 * own.q,
        "{wanted:?}, {own:?}"
    );
    assert_eq!(asks(&current), wanted);
    assert_eq!(asks(&anew), wanted);
}
