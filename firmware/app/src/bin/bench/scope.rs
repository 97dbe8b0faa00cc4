//! The scope: what the recorder adds to a control tick, idle and with eight channels.

use core::sync::atomic::AtomicU32;

use canopen::{Duration, Instant};
use cia402::recorder::{Edge, Memory, Orders, Recorder, Setup, Signal, State, Trigger};
use cia402::{Actuals, Drive, DriveConfig, Exchange};
use motion::{AxisConfig, Clock, DriverTiming};

use crate::{count, row};

const TICK: Duration = Duration::millis(1);

static MEMORY: Memory<[AtomicU32; 512]> = Memory::new();

/// Eight values, 24 bytes, and a trigger that does not come.
const EIGHT: Setup = Setup {
    channels: [
        Some(Signal::Statusword),
        Some(Signal::PositionDemandValue),
        Some(Signal::PositionActualValue),
        Some(Signal::VelocityDemandValue),
        Some(Signal::VelocityActualValue),
        Some(Signal::FollowingErrorActualValue),
        Some(Signal::ErrorCode),
        Some(Signal::ModesOfOperationDisplay),
    ],
    trigger: Trigger {
        signal: Some(Signal::VelocityActualValue),
        edge: Edge::Rising,
        level: 1_000,
        mask: 0,
    },
    ..Setup::NONE
};

#[inline(never)]
fn tick(recorder: &mut Recorder<&'static Memory>, drive: &Drive, exchange: &mut Exchange) -> u32 {
    count(|| recorder.tick(drive, exchange)).0
}

/// All workloads of the scope.
pub fn run() {
    let drive: Drive = Drive::new(DriveConfig {
        axis: AxisConfig {
            clock: Clock::new(84_000_000).unwrap(),
            time_slice: 84_000,
            timing: DriverTiming {
                pulse_high: 210,
                pulse_low: 210,
                direction_setup: 420,
                direction_hold: 420,
            },
        },
        tick: TICK,
        refills: 1,
    });
    let mut exchange = Exchange::new();
    exchange.publish(&Actuals {
        at: Instant::from_ticks(1_000),
        ..Actuals::NONE
    });
    let mut recorder = Recorder::new(&MEMORY as &'static Memory, TICK);
    tick(&mut recorder, &drive, &mut exchange);
    row(
        "scope: behind a control tick, idle",
        tick(&mut recorder, &drive, &mut exchange),
    );
    exchange.order(Orders {
        arm: Some(EIGHT),
        ..Orders::default()
    });
    for _ in 0..100 {
        tick(&mut recorder, &drive, &mut exchange);
    }
    assert_eq!(exchange.scope().state, State::Armed);
    row(
        "scope: behind a control tick, eight channels armed",
        tick(&mut recorder, &drive, &mut exchange),
    );
}
