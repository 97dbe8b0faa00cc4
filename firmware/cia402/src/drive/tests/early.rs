//! A tick between two control ticks: it carries out a stop at once, and leaves everything else to the regular ones.

use std::vec::Vec;

use canopen::{Duration, Instant};
use motion::{Ramps, SignedSpeed};

use crate::configuration::HomingConfiguration;
use crate::cyclic::SyncEvent;
use crate::exchange::Actuals;
use crate::inputs::{Edge, Edges, InputConfiguration};
use crate::state_machine::State;
use crate::statusword::WARNING;
use crate::testing::Rig;

/// A drive that cruises at 10 steps a tick.
fn cruising() -> Rig {
    let mut rig = Rig::enabled();
    rig.set_point(100_000, 0);
    rig.ticks(200);
    assert_eq!(rig.speed(), 10);
    rig
}

/// A tick, and the controlword so many microseconds behind it. Returns whether an early tick was called for; it has run then.
fn written_behind_a_tick(rig: &mut Rig, behind: u64, controlword: u16) -> bool {
    rig.tick_and_play(Duration::micros(behind));
    rig.write(controlword);
    let is_called = rig.exchange.calls_early();
    let rest = Duration::micros(1_000 - behind);
    if is_called {
        rig.early_tick_and_play(rest);
    } else {
        rig.tick_and_play(rest);
    }
    is_called
}

#[test]
fn m07_a_command_to_stop_is_carried_out_before_the_next_tick() {
    for (controlword, state) in [
        (0x010F, State::OperationEnabled),
        (0x000B, State::QuickStopActive),
        (0x0007, State::OperationEnabled),
        (0x0006, State::ReadyToSwitchOn),
        (0x0000, State::SwitchOnDisabled),
    ] {
        let mut rig = cruising();
        assert!(written_behind_a_tick(&mut rig, 300, controlword));
        assert_eq!(rig.state(), state, "{controlword:04X}h");
        let stops = matches!(state, State::OperationEnabled | State::QuickStopActive);
        assert_eq!(rig.outputs.power_stage, stops);
        // What the ticks behind it find is a motor that slows down already: a stop that is asked for later ends later.
        let mut late = cruising();
        late.tick();
        late.write(controlword);
        late.tick();
        assert!(rig.rest() <= late.rest(), "{controlword:04X}h");
    }
}

#[test]
fn m07_without_power_the_pulses_end_at_once() {
    let mut rig = cruising();
    rig.tick_and_play(Duration::micros(300));
    let position = rig.motor.position;
    rig.write(0x0000);
    rig.early_tick_and_play(Duration::micros(700));
    assert_eq!(rig.motor.position, position);
}

#[test]
fn what_stops_nothing_waits_for_the_control_tick() {
    for controlword in [0x0F, 0x1F, 0x3F, 0x8F, 0x020F, 0x4F] {
        let mut rig = cruising();
        assert!(!written_behind_a_tick(&mut rig, 300, controlword));
    }
    // Nor is there haste where the motor stands.
    let mut rig = Rig::enabled();
    for controlword in [0x010F, 0x0F, 0x0B] {
        assert!(!written_behind_a_tick(&mut rig, 300, controlword));
    }
}

#[test]
fn m39_a_motor_that_is_about_to_move_is_stopped_as_well() {
    let mut rig = Rig::enabled();
    rig.set_point(100_000, 0);
    assert!(written_behind_a_tick(&mut rig, 300, 0x011F));
    assert!(rig.rest() < 2);
}

#[test]
fn a_master_that_changes_its_mind_has_one_early_tick_between_two() {
    let mut rig = cruising();
    let mut early = 0;
    for _ in 0..20 {
        rig.tick_and_play(Duration::micros(100));
        let mut in_period = 0;
        for half in 0..9 {
            rig.write(if half % 2 == 0 { 0x010F } else { 0x0F });
            if rig.exchange.calls_early() {
                in_period += 1;
                rig.early_tick_and_play(Duration::micros(100));
            } else {
                rig.motor_plays(Duration::micros(100));
            }
        }
        assert!(in_period <= 1);
        early += in_period;
    }
    assert!(early > 10, "{early}");
}

#[test]
fn d23_a_network_that_is_lost_stops_the_motor_at_once() {
    let mut rig = cruising();
    rig.tick_and_play(Duration::micros(300));
    rig.commands.remote = false;
    rig.post();
    assert!(rig.exchange.calls_early());
    rig.early_tick_and_play(Duration::micros(700));
    assert_eq!(rig.state(), State::QuickStopActive);
}

#[test]
fn d31_a_limit_switch_that_is_set_up_just_before_a_stop_is_seen() {
    let mut rig = cruising();
    rig.digital.levels = 4;
    rig.ticks(10);
    rig.tick_and_play(Duration::micros(600));
    rig.configuration.inputs.positive_limit = 4;
    rig.write(0x010F);
    assert!(rig.exchange.calls_early());
    rig.early_tick_and_play(Duration::micros(400));
    rig.tick();
    assert_eq!(rig.actuals().digital_inputs & 7, 2);
    rig.write(0x0F);
    rig.tick();
    assert!(rig.limited());
}

#[test]
fn what_is_set_up_of_the_beat_just_before_a_stop_is_seen() {
    let mut rig = Rig::new();
    rig.commands.mode = 8;
    rig.configuration.cyclic.period = 1_000;
    rig.enable();
    for number in 0..100 {
        sync_event(&mut rig, Some(5 * number));
        rig.tick();
    }
    assert!(rig.actuals().is_moving && !rig.has(WARNING));
    rig.tick_and_play(Duration::micros(600));
    rig.configuration.cyclic.cycle = 2_000;
    rig.write(0x010F);
    assert!(rig.exchange.calls_early());
    rig.early_tick_and_play(Duration::micros(400));
    rig.tick();
    assert!(rig.has(WARNING));
}

/// A drive that cruises with this 60B8h, and its probe 1 on input 4.
fn probing(function: u16) -> Rig {
    let mut rig = cruising();
    rig.configuration.inputs.touch_probes = [8, 0];
    rig.commands.touch_probe_function = function;
    rig.post();
    rig.ticks(2);
    rig
}

/// 600 µs behind a tick another 60B8h comes with a halt, 300 µs before it an edge.
fn edge_before_a_stop(rig: &mut Rig, function: u16) {
    rig.tick_and_play(Duration::micros(300));
    let edge = Edges::one(Edge {
        position: i32::try_from(rig.motor.position).unwrap(),
        time: 7,
    });
    rig.motor_plays(Duration::micros(300));
    rig.commands.touch_probe_function = function;
    rig.write(0x010F);
    assert!(rig.exchange.calls_early());
    rig.early_tick_and_play(Duration::micros(400));
    rig.digital.levels = 8;
    rig.digital.changed = 8;
    rig.digital.captured[3].rose = Some(edge);
    rig.tick();
}

#[test]
fn m70_a_probe_switched_on_with_a_stop_samples_no_edge_from_before() {
    let mut rig = probing(0);
    edge_before_a_stop(&mut rig, 0x11);
    let (latched, _) = rig.exchange.take_news();
    assert_eq!((latched.status, latched.counters[0]), (1, 0));
}

#[test]
fn m70_a_probe_switched_off_with_a_stop_keeps_the_edge_from_before() {
    let mut rig = probing(0x11);
    edge_before_a_stop(&mut rig, 0);
    let (latched, _) = rig.exchange.take_news();
    assert_eq!((latched.status, latched.counters[0]), (0, 1));
    assert_eq!(latched.times[0], 7);
}

#[test]
fn m70_a_probe_switched_off_and_on_with_a_stop_starts_anew() {
    let mut rig = probing(0x11);
    rig.digital.levels = 8;
    rig.tick();
    assert_eq!(rig.exchange.take_news().0.status, 3);
    rig.tick_and_play(Duration::micros(600));
    rig.commands.touch_probes_off = 1;
    rig.write(0x010F);
    rig.commands.touch_probes_off = 0;
    rig.early_tick_and_play(Duration::micros(400));
    rig.tick();
    assert_eq!(rig.exchange.take_news().0.status, 1);
    // Once.
    rig.digital.levels = 0;
    rig.tick();
    rig.digital.levels = 8;
    rig.ticks(2);
    assert_eq!(rig.exchange.take_news().0.status, 3);
}

/// What a master does.
type Act = fn(&mut Rig);

/// A stop that forgets records, and what the master wants again before the next control tick.
fn records_behind_a_stop(stop: Act, again: Act) -> Rig {
    let mut rig = Rig::new();
    rig.commands.mode = 7;
    rig.configuration.cyclic.period = 1_000;
    rig.enable();
    rig.write(0x1F);
    for number in 1..=30 {
        rig.exchange.record(5 * number);
        if number > 10 {
            sync_event(&mut rig, None);
        }
        rig.tick();
    }
    assert!(rig.actuals().is_moving && rig.actuals().sync.buffered > 5);
    rig.exchange.record(200);
    sync_event(&mut rig, None);
    rig.tick_and_play(Duration::micros(200));
    rig.exchange.record(205);
    rig.motor_plays(Duration::micros(100));
    stop(&mut rig);
    assert!(rig.exchange.calls_early());
    rig.early_tick_and_play(Duration::micros(300));
    again(&mut rig);
    rig.motor_plays(Duration::micros(400));
    rig
}

/// A SYNC, 250 µs behind the tick that was last.
fn sync_event(rig: &mut Rig, position: Option<i32>) {
    rig.exchange.sync_event(SyncEvent {
        at: rig.now() - Duration::micros(750),
        is_sync: true,
        position,
        velocity: None,
        torque: None,
    });
}

#[test]
fn m68_records_from_before_a_stop_that_forgets_them_are_not_carried_out() {
    let stops: [(Act, Act); 2] = [
        (|rig| rig.write(0x17), |rig| rig.write(0x1F)),
        (
            |rig| {
                rig.commands.mode = 1;
                rig.write(0x011F);
            },
            |rig| {
                rig.commands.mode = 7;
                rig.write(0x1F);
            },
        ),
    ];
    for (number, (stop, again)) in stops.into_iter().enumerate() {
        let mut rig = records_behind_a_stop(stop, again);
        rig.tick();
        assert_eq!(rig.actuals().sync.buffered, 0, "{number}");
        // What comes from now on is kept.
        for _ in 0..5 {
            rig.exchange.record(100);
        }
        rig.tick();
        assert!(rig.actuals().sync.buffered > 2, "{number}");
    }
    // Halt alone forgets none.
    let mut rig = records_behind_a_stop(|rig| rig.write(0x011F), |rig| rig.write(0x1F));
    rig.tick();
    assert!(rig.actuals().sync.buffered > 6);
}

#[test]
fn m68_a_record_goes_by_the_controlword_that_it_finds() {
    let buffered = |before, behind| {
        let mut rig = Rig::new();
        rig.commands.mode = 7;
        rig.enable();
        rig.write(before);
        rig.tick();
        rig.exchange.record(100);
        rig.write(behind);
        rig.tick();
        rig.actuals().sync.buffered
    };
    // Halt while bit 4 is 0 takes none.
    assert_eq!(buffered(0x0F, 0x010F), 1);
    assert_eq!(buffered(0x010F, 0x0F), 0);
    assert_eq!(buffered(0x0F, 0x0F), 1);
    assert_eq!(buffered(0x010F, 0x010F), 0);
    // Neither does a command to leave, even if it is taken back before the tick that comes behind the record.
    assert_eq!(buffered(0x17, 0x1F), 0);
    assert_eq!(buffered(0x07, 0x0F), 0);
}

/// What a master does in the tick with this number.
type Script = fn(&mut Rig, u64);

/// Every set of actual values, and the motor behind each tick. Early ticks run
/// behind regular ones as they may: while the motor has pulses to come.
fn run(rig: Rig, script: Script, is_disturbed: bool) -> Vec<(Actuals, i64)> {
    let mut rig = rig;
    let mut random = 1_u32;
    let mut all = Vec::new();
    for number in 0..1_500 {
        script(&mut rig, number);
        random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let behind = u64::from(random >> 8) % 998 + 1;
        let actuals = rig.tick_and_play(Duration::micros(behind));
        let rest = Duration::micros(1_000 - behind);
        if is_disturbed && actuals.is_moving && random >> 30 != 0 {
            rig.early_tick_and_play(rest);
        } else {
            rig.motor_plays(rest);
        }
        all.push((actuals, rig.motor.position));
    }
    all
}

/// Early ticks that have nothing to carry out change nothing.
fn is_undisturbed(made: impl Fn() -> Rig, script: Script) {
    let plain = run(made(), script, false);
    let disturbed = run(made(), script, true);
    assert!(plain.iter().any(|(_, position)| *position != 0));
    for (number, pair) in plain.iter().zip(&disturbed).enumerate() {
        assert_eq!(pair.0, pair.1, "tick {number}");
    }
}

#[test]
fn m34_early_ticks_shorten_no_time_of_profile_position() {
    let enabled = || {
        let mut rig = Rig::enabled();
        rig.configuration.position_window_time = 7;
        rig
    };
    is_undisturbed(enabled, |rig, number| match number {
        10 => rig.set_point(3_000, 0),
        50 => rig.set_point(500, 0),
        900 => rig.set_point(-2_000, 0x20),
        _ => {}
    });
    let smooth = || {
        let mut rig = Rig::enabled();
        rig.configuration.profile.ramps = Ramps::SinSquared;
        rig
    };
    is_undisturbed(smooth, |rig, number| match number {
        10 => rig.set_point(3_000, 0),
        600 => rig.set_point(-2_000, 0x20),
        700 => rig.set_point(2_000, 0x20),
        _ => {}
    });
}

#[test]
fn m52_early_ticks_take_no_edge_twice_and_shorten_no_debounce() {
    let homing = || {
        let mut rig = Rig::new();
        rig.commands.mode = 6;
        rig.configuration.inputs = InputConfiguration {
            home: 1,
            negative_limit: 2,
            positive_limit: 4,
            debounce: 5,
            ..InputConfiguration::NONE
        };
        rig.configuration.homing = HomingConfiguration {
            method: 19,
            search_speed: 10_000.into(),
            zero_speed: 1_000.into(),
            acceleration: 200_000,
            ..HomingConfiguration::NONE
        };
        rig.enable();
        rig
    };
    is_undisturbed(homing, |rig, number| {
        rig.digital.levels = u8::from(rig.motor.position >= 300);
        if number == 10 {
            rig.write(0x1F);
        }
    });
    let limited = || {
        let mut rig = homing();
        rig.commands.mode = 1;
        rig.post();
        rig.ticks(3);
        rig
    };
    is_undisturbed(limited, |rig, number| {
        // It chatters before it stays.
        rig.digital.levels = if number > 200 || number % 7 == 0 {
            4
        } else {
            0
        };
        if number == 10 {
            rig.set_point(100_000, 0);
        }
    });
}

#[test]
fn m63_early_ticks_take_no_set_point_twice_and_leave_sync_its_beat() {
    let cyclic = |mode| {
        let mut rig = Rig::new();
        rig.commands.mode = mode;
        rig.configuration.cyclic.period = 1_000;
        rig.enable();
        rig
    };
    /// A SYNC in each millisecond, 250 µs behind the tick that is next, with a set-point.
    fn sync_event(rig: &mut Rig, number: u64) {
        let at = rig.now() - Duration::micros(750);
        // There and back, with breaks of which one is too long.
        let is_there = number % 200 != 7 && !(1_000..1_003).contains(&number);
        let distance = 5 * i32::try_from(number % 600).unwrap();
        let position = if number % 1_200 < 600 {
            distance
        } else {
            3_000 - distance
        };
        rig.exchange.sync_event(SyncEvent {
            at: Instant::from_ticks(at.ticks()),
            is_sync: true,
            position: is_there.then_some(position),
            velocity: is_there.then(|| SignedSpeed::from(3 * position)),
            torque: None,
        });
    }
    is_undisturbed(|| cyclic(8), sync_event);
    is_undisturbed(|| cyclic(9), sync_event);
    is_undisturbed(
        || cyclic(7),
        |rig, number| {
            if number == 10 {
                rig.write(0x1F);
            }
            rig.exchange.record(5 * i32::try_from(number).unwrap());
            sync_event(rig, number);
        },
    );
}
