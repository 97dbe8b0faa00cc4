//! What interrupts above the control tick ask of the timers.

use super::registers::{Register, Registers, bits};

/// A capture channel of the counter that has a pin of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CaptureChannel {
    /// TIM2_CH1.
    One,
    /// TIM2_CH2.
    Two,
    /// TIM2_CH4.
    Four,
}

impl CaptureChannel {
    /// Its flag, and its register.
    const fn parts(self) -> (u32, Register) {
        match self {
            Self::One => (bits::CC1IF, Register::CounterCcr1),
            Self::Two => (bits::CC2IF, Register::CounterCcr2),
            Self::Four => (bits::CC4IF, Register::CounterCcr4),
        }
    }
}

/// Ticks of TIM1 between an edge and its interrupt: 20 µs at 168 MHz, which is far more than there should be.
const LATEST: u32 = 3_360;

/// What the counter showed when an edge came, from the interrupt of that edge: what the channel has captured. Where there is no channel, or it
/// has captured nothing of late, it is what the counter shows now.
///
/// The channel has a pin and a filter of its own. A slow edge may come there when its interrupt is over; what is captured then waits for the
/// next edge, and is none of it. So no more pulses may have come since than at the present rate come in 20 µs, and one.
/// [`Output::position`](super::Output::position) forgets what was captured before it.
pub fn count_at_edge(registers: &impl Registers, channel: Option<CaptureChannel>) -> u32 {
    let captured = channel.map(CaptureChannel::parts);
    let captured = captured
        .filter(|(flag, _)| registers.read(Register::CounterSr) & flag != 0)
        .map(|(_, register)| registers.read(register));
    // The period of the next run, which is about that of this one. Where pulses are few it is long, and a part of theirs.
    let period = registers.read(Register::Arr).wrapping_add(1);
    let max = LATEST.checked_div(period).unwrap_or(0).wrapping_add(1);
    let now = registers.read(Register::CounterCnt);
    captured
        .filter(|captured| now.wrapping_sub(*captured) <= max)
        .unwrap_or(now)
}

/// The break input has cut the outputs off, and the timer goes on unseen: no pulse begins from here on, so that the counter shows what has left,
/// but for the few pulses up to this. From the interrupt of the break (TIM1_BRK), which then is off until the next train.
pub fn on_break(registers: &mut impl Registers) {
    for (register, value) in [
        (Register::Ccmr1, bits::CHANNEL_1_LOW | bits::CHANNEL_2_PWM),
        (Register::Cr1, bits::URS | bits::ARPE),
        // Its flag stays while the input is active.
        (Register::Dier, 0),
    ] {
        registers.write(register, value);
    }
}
