//! From an order to the end of the first slower step, at the pins.

use canopen::{BitRate, Duration, Frame, Instant};

use super::{PROFILE_POSITION, enabled};
use crate::timer_model::board::Board;
use master::Failure;
use master::bus::Station;
use master::bus::simulated::Bus;

/// What stops the motor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// Bit 8 of the controlword.
    Halt,
    /// Bit 2 of the controlword falls.
    QuickStop,
    /// Bit 3 of the controlword falls.
    DisableOperation,
}

/// How the velocity changes, 6086h.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Profile {
    /// 0.
    Linear,
    /// 1: sin² ramps as long as linear ones; 20A0h lets the quick stop ramp have them too.
    SinSquared,
    /// 2: the moving average, at [`JERK`] too; 20A0h as for sin².
    MovingAverage,
}

/// Steps/s³: [`super::STEEP`] within 2 ms. A ramp begins the more slowly the less it is.
pub const JERK: u32 = 2_500_000_000;

/// What moves the motor until it is stopped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// 60FFh.
    ProfileVelocity,
    /// A target that is far away, at 6081h.
    ProfilePosition,
}

/// The longest reactions, in microseconds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Reaction {
    /// From the control tick that has found the order, an early one or a regular one.
    pub from_tick: u64,
    /// From the last bit of the frame that brought it, which may have come just behind a control tick.
    pub from_frame: u64,
}

impl Reaction {
    /// The longer of two, each by itself.
    pub fn max(self, other: Self) -> Self {
        Self {
            from_tick: self.from_tick.max(other.from_tick),
            from_frame: self.from_frame.max(other.from_frame),
        }
    }
}

/// The velocity that is left, in steps/s.
const VELOCITY: i32 = 100_000;

/// A target that is not reached.
const FAR: i32 = 2_000_000_000;

/// Each order comes so many microseconds later, in relation to the control tick.
const APART: u64 = 47;

/// So many orders fall all over the millisecond of a control tick.
const ORDERS: u64 = 1_000 / APART + 1;

/// The longest of many reactions, while the motor cruises at 100,000 steps/s; it stops with 5,000,000 steps/s². The refills come `phase`
/// behind the control ticks. `ramp`, the profile acceleration, decides where in a time slice the cruise begins.
///
/// # Errors
/// What the drive did not answer rightly.
///
/// # Panics
/// If there is no slower step.
pub fn longest(
    order: Order,
    profile: Profile,
    mode: Mode,
    phase: Duration,
    ramp: u32,
) -> Result<Reaction, Failure> {
    let (mut master, handle) = enabled(Bus::new(BitRate::Kbit1000), phase)?;
    let node = Board::NODE;
    let code: i16 = match profile {
        Profile::Linear => 0,
        Profile::SinSquared => 1,
        Profile::MovingAverage => 2,
    };
    master.write(node, 0x6086, 0, code)?;
    master.write(node, 0x60A4, 1, JERK)?;
    master.write(node, 0x20A0, 0, u8::from(profile != Profile::Linear))?;
    master.write(node, 0x6083, 0, ramp)?;
    match mode {
        Mode::ProfileVelocity => master.write(node, 0x60FF, 0, VELOCITY)?,
        Mode::ProfilePosition => {
            master.write(node, 0x6060, 0, PROFILE_POSITION)?;
            master.write(node, 0x6081, 0, VELOCITY.cast_unsigned())?;
            master.write(node, 0x607A, 0, FAR)?;
            master.wait(Duration::millis(5))?;
            master.controlword(node, 0x1F);
        }
    }
    master.wait(Duration::millis(100))?;
    // From here on orders come to the microsecond, and no bus is needed.
    let mut now = master.now() + Duration::millis(10);
    let mut board = master.bus_mut().detach(handle);
    let mut longest = Reaction::default();
    for number in 0..ORDERS {
        let reaction = once(&mut board, now + Duration::micros(number * APART), order);
        longest = longest.max(reaction);
        // At rest after 20 ms; back at the velocity, in whole milliseconds from the order before.
        let back: &[u16] = match (order, mode) {
            (Order::Halt, _) | (Order::DisableOperation, Mode::ProfileVelocity) => &[0x0F],
            (Order::DisableOperation, Mode::ProfilePosition) => &[0x0F, 0x1F],
            (Order::QuickStop, Mode::ProfileVelocity) => &[0x06, 0x07, 0x0F],
            (Order::QuickStop, Mode::ProfilePosition) => &[0x06, 0x07, 0x0F, 0x1F],
        };
        now += Duration::millis(60);
        for controlword in back {
            give(&mut board, *controlword, now);
            now += Duration::millis(5);
        }
        now += Duration::millis(40);
    }
    Ok(longest)
}

/// An order at `at`, and what becomes of it within 40 ms.
fn once(board: &mut Board, at: Instant, order: Order) -> Reaction {
    run(board, at - Duration::millis(1));
    board.model().judge_mut().log = Some(Vec::new());
    run(board, at);
    let before = board.last_tick();
    give(
        board,
        match order {
            Order::Halt => 0x010F,
            Order::QuickStop => 0x0B,
            Order::DisableOperation => 0x07,
        },
        at,
    );
    // The tick that finds it is the first one behind it.
    let mut tick = at;
    while board.last_tick() == before {
        tick += Duration::micros(1);
        run(board, tick);
    }
    let tick = board.last_tick();
    run(board, at + Duration::millis(40));
    let judge = board.model().judge();
    let log = judge.log.as_deref().unwrap_or_default();
    let steps = || {
        log.windows(2).filter_map(|pair| match pair {
            [(rose, _), (next, _)] => Some((*next, next - rose)),
            _ => None,
        })
    };
    let usual = steps()
        .take_while(|(next, _)| *next <= Board::ticks(at))
        .map(|(_, period)| period)
        .max()
        .expect("a cruise");
    let (slower, _) = steps()
        .find(|(_, period)| *period > usual)
        .expect("a slower step");
    let since = |start: Instant| {
        (slower - Board::ticks(start)).div_ceil(Board::ticks(Instant::from_ticks(1)))
    };
    Reaction {
        from_tick: since(tick),
        from_frame: since(at),
    }
}

fn give(board: &mut Board, controlword: u16, at: Instant) {
    let frame = Frame::data_frame(0x200 + u16::from(Board::NODE), &controlword.to_le_bytes());
    board.receive(&frame, at);
}

/// Lets time pass.
fn run(board: &mut Board, until: Instant) {
    let mut next = board.poll(until);
    while next <= until {
        next = board.poll(until);
    }
    while board.transmit().is_some() {}
}
