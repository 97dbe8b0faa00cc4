//! The figures are within their goals.

use canopen::{BitRate, Duration, Frame, Instant};
use motion::Ramps;

use super::count::{long_moves, sequences};
use super::reaction::{Mode, Order, Profile, longest};
use super::{duration, enabled, position, rate};
use crate::timer_model::board::Board;
use master::bus::Station;
use master::bus::simulated::Bus;

#[test]
fn no_pulse_is_too_many_or_too_few() {
    // Four moves, at least one with each kind of ramps.
    let moves = long_moves(13_000_000);
    assert!(moves.pulses >= 13_000_000);
    assert_eq!((moves.error, moves.underruns), (0, 0));
    let counted = sequences(200);
    assert!(counted.pulses > 1_000);
    assert_eq!(counted.error, 0);
    // Nothing but a processor that stands still makes a gap.
    assert!(counted.pauses > 0 && counted.underruns <= counted.pauses);
}

#[test]
fn moves_end_on_the_tick() {
    let linear = duration::linear();
    assert_eq!(linear.moves, 22);
    assert!(linear.ticks <= 1.0, "{linear:?}");
}

#[test]
fn pulses_leave_where_the_plan_has_them() {
    let jerk = 1_000_000_000;
    for ramps in [Ramps::Linear, Ramps::SinSquared, Ramps::MovingAverage(jerk)] {
        for (velocity, goal) in [
            (100_000, 0.1),
            (499_259, 0.1),
            (500_000, 0.1),
            (998_000, 0.5),
            (1_000_000, 0.5),
        ] {
            let error = position::greatest_error(velocity, super::STEEP, ramps);
            assert!(
                0.0 < error && error <= goal,
                "{ramps:?} {velocity}: {error}"
            );
        }
    }
}

#[test]
fn a_million_steps_a_second_on_a_full_bus() {
    let served = rate::at(1_000_000, 1).unwrap();
    assert_eq!((served.rate, served.error), (1_000_000, 0));
    assert!(served.samples >= 2_000 && served.transfers >= 2_000);
    assert!(served.frames > 10_000);
}

#[test]
fn the_ceiling_is_that_of_the_driver() {
    let served = rate::at(4_941_176, 1).unwrap();
    assert_eq!((served.rate, served.error), (4_941_176, 0));
}

#[test]
fn a_stop_is_felt_within_a_millisecond_of_its_frame() {
    for (order, profile, phase, ramp) in [
        (Order::Halt, Profile::Linear, 0, 5_000_000),
        (Order::Halt, Profile::SinSquared, 200, 5_000_000),
        (Order::QuickStop, Profile::Linear, 125, 4_960_000),
        (Order::QuickStop, Profile::SinSquared, 100, 5_000_000),
        (Order::DisableOperation, Profile::Linear, 150, 4_970_000),
        (Order::DisableOperation, Profile::SinSquared, 25, 5_000_000),
        (Order::Halt, Profile::MovingAverage, 50, 4_990_000),
        (Order::QuickStop, Profile::MovingAverage, 200, 5_000_000),
        (
            Order::DisableOperation,
            Profile::MovingAverage,
            100,
            4_970_000,
        ),
    ] {
        for mode in [Mode::ProfileVelocity, Mode::ProfilePosition] {
            let phase = Duration::micros(phase);
            let reaction = longest(order, profile, mode, phase, ramp).unwrap();
            let case = format!("{order:?}, {profile:?}, {mode:?}: {reaction:?}");
            assert!(reaction.from_frame <= 1_000, "{case}");
            // It is not felt before the committed pulses have left.
            assert!(reaction.from_frame > 500, "{case}");
        }
    }
}

/// Emergency messages of a drive whose ticks take so long, early ones too, in a slow cruise that is stopped twice in a row, at many moments:
/// first in an early tick, then in the regular one behind it.
fn warnings(busy: Duration, phase: u64) -> usize {
    let (mut master, handle) =
        enabled(Bus::new(BitRate::Kbit1000), Duration::micros(phase)).unwrap();
    for (index, value) in [(0x6086, 1_i16), (0x605D, 2)] {
        master.write(Board::NODE, index, 0, value).unwrap();
    }
    master.write(Board::NODE, 0x20A0, 0, 1_u8).unwrap();
    master.write(Board::NODE, 0x6083, 0, 500_000_u32).unwrap();
    master.write(Board::NODE, 0x60FF, 0, 3_000_i32).unwrap();
    master.wait(Duration::millis(100)).unwrap();
    let mut now = master.now();
    let mut board = master.bus_mut().detach(handle);
    board.set_busy(busy);
    let mut emergencies = 0;
    let mut run = |board: &mut Board, until| {
        while board.poll(until) <= until {}
        while let Some(frame) = board.transmit() {
            let emergency = 0x80 + u16::from(Board::NODE);
            emergencies += usize::from(frame.standard_id() == Some(emergency));
        }
    };
    let order = |controlword: u16| {
        Frame::data_frame(0x200 + u16::from(Board::NODE), &controlword.to_le_bytes())
    };
    for moment in (0..1_000).step_by(31) {
        now += Duration::millis(50);
        for (controlword, behind) in [
            (0x010F, moment),
            (0x010B, moment + 90),
            (0x06, 40_000),
            (0x07, 45_000),
            (0x0F, 50_000),
        ] {
            let at = now + Duration::micros(behind);
            run(&mut board, at);
            board.receive(&order(controlword), at);
        }
        now += Duration::millis(100);
        run(&mut board, now);
    }
    emergencies
}

#[test]
fn two_stops_in_long_ticks_in_a_row_make_no_pause() {
    for phase in [0, 60, 125, 190] {
        for busy in [90, 180, 450, 900] {
            let warnings = warnings(Duration::micros(busy), phase);
            assert_eq!(warnings, 0, "ticks of {busy} us, {phase} us");
        }
    }
}

/// Between two software limits, forth and back, with a halt somewhere on the way, on each kind of ramps: the end of each motion is decided in ticks that refills
/// come into at any moment.
#[test]
fn a_limit_holds_whenever_a_refill_comes() {
    const LIMIT: i64 = 20_000;
    const VELOCITY: i32 = 200_000;
    for (profile, phase) in [(0_i16, 20), (1, 130), (2, 190)] {
        let phase = Duration::micros(phase);
        let (mut master, handle) = enabled(Bus::new(BitRate::Kbit1000), phase).unwrap();
        let node = Board::NODE;
        // Home is where it stands.
        master.write(node, 0x6098, 0, 37_i8).unwrap();
        master.write(node, 0x6060, 0, 6_i8).unwrap();
        master.wait(Duration::millis(100)).unwrap();
        master.controlword(node, 0x1F);
        master.wait(Duration::millis(20)).unwrap();
        let statusword: u16 = master.read(node, 0x6041, 0).unwrap();
        assert_ne!(statusword & 1 << 12, 0, "homing attained");
        master.controlword(node, 0x0F);
        for (sub_index, limit) in [(1, -LIMIT), (2, LIMIT)] {
            master.write(node, 0x607D, sub_index, limit as i32).unwrap();
        }
        master.write(node, 0x6086, 0, profile).unwrap();
        master.write(node, 0x60A4, 1, 500_000_000_u32).unwrap();
        master.write(node, 0x6083, 0, 2_000_000_u32).unwrap();
        master.write(node, 0x6084, 0, 2_000_000_u32).unwrap();
        master.write(node, 0x6060, 0, 3_i8).unwrap();
        let (mut now, mut velocity) = (master.now(), VELOCITY);
        let mut board = master.bus_mut().detach(handle);
        board.set_busy(Duration::micros(180));
        let mut reached = 0;
        for moment in (0..100_000).step_by(4_999) {
            master_says(&mut board, now, 0x60FF, velocity);
            let halt = now + Duration::micros(5_000 + moment);
            let release = halt + Duration::millis(100);
            let end = release + Duration::millis(600);
            for (until, controlword) in [(halt, 0x010F), (release, 0x0F), (end, 0x0F)] {
                while now < until {
                    now = (now + Duration::micros(250)).min(until);
                    while board.poll(now) <= now {}
                    while board.transmit().is_some() {}
                    board.pulses_at(now);
                    let position = board.model().judge().position;
                    assert!(position.abs() <= LIMIT, "{position}, {profile}, {moment}");
                }
                controlword_at(&mut board, now, controlword);
            }
            let position = board.model().judge().position;
            reached += usize::from(position == LIMIT * i64::from(velocity.signum()));
            velocity = -velocity;
        }
        assert!(reached > 15, "{reached} with {profile}");
    }
}

fn controlword_at(board: &mut Board, now: Instant, controlword: u16) {
    let frame = Frame::data_frame(0x200 + u16::from(Board::NODE), &controlword.to_le_bytes());
    board.receive(&frame, now);
}

/// An expedited download of 32 bits.
fn master_says(board: &mut Board, now: Instant, index: u16, value: i32) {
    let ([low, high], [a, b, c, d]) = (index.to_le_bytes(), value.to_le_bytes());
    let frame = Frame::data_frame(
        0x600 + u16::from(Board::NODE),
        &[0x23, low, high, 0, a, b, c, d],
    );
    board.receive(&frame, now);
}

/// An error of the DMA, at any moment of a cruise: the emergency message leaves within a control tick, which may come 50 µs late, and the motor has
/// no power. Then the drive moves as before.
#[test]
fn a_transfer_error_is_told_within_a_control_tick() {
    let (mut master, handle) = enabled(Bus::new(BitRate::Kbit1000), Duration::micros(125)).unwrap();
    let node = u16::from(Board::NODE);
    master.write(Board::NODE, 0x60FF, 0, 100_000_i32).unwrap();
    master.wait(Duration::millis(100)).unwrap();
    let mut now = master.now();
    let mut board = master.bus_mut().detach(handle);
    for moment in (0..1_000).step_by(37) {
        now += Duration::millis(50);
        let failed = now + Duration::micros(moment);
        while board.poll(failed) <= failed {}
        assert!(board.pulses_at(failed) > 0, "it moves");
        while board.transmit().is_some() {}
        board.model().fail_stream();
        let mut told = failed;
        let code = loop {
            told += Duration::micros(1);
            board.poll(told);
            let frame = std::iter::from_fn(|| board.transmit())
                .find(|frame| frame.standard_id() == Some(0x80 + node));
            if let Some(frame) = frame {
                let data = frame.payload();
                break u16::from_le_bytes([data[0], data[1]]);
            }
            assert!(told <= failed + Duration::micros(1_100), "{moment}");
        };
        assert_eq!(code, 0x5200);
        let stood = board.pulses_at(told);
        now = told;
        for controlword in [0x80_u16, 0x06, 0x07, 0x0F] {
            // A state is shown for 50 ms, where no transmit PDO tells of it.
            now += Duration::millis(60);
            assert_eq!(board.pulses_at(now), stood);
            let is_fault = board.state() == cia402::State::Fault;
            assert_eq!(is_fault, controlword == 0x80, "{moment}");
            let frame = Frame::data_frame(0x200 + node, &controlword.to_le_bytes());
            board.receive(&frame, now);
        }
        now += Duration::millis(50);
        assert!(board.pulses_at(now) > stood, "it moves again");
    }
}
