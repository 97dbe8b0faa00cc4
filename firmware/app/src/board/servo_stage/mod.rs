//! What the boards with a servo share: the loops in the interrupt of the converters, TIM1 with the
//! bridges of the motor, the encoder at TIM3, and the control tick's end of the link.
//!
//! What a board has of its own here it gives as [`own`]: its motor, the channels of its converters,
//! its bridges, how the gates go on and off, and where the index of its encoder was.

pub mod converters;
pub mod encoder;
pub mod lines;
pub mod orders;
pub mod pwm;
pub mod stage;

use core::mem::MaybeUninit;
use core::ptr::addr_of_mut;

use ::servo::modulation::Widths;
use cortex_m::peripheral::NVIC;
use motion::DriverTiming;
use runtime::servo::{self, Link, Loops, Port, ServoData};
use stm32f4xx_hal::pac;

use ::servo::Motor;

use self::orders::{LinkedServoObjects, Orders};
use super::chip::{self, TIMERS_HZ};
use super::{own, Board, Selected};
use crate::control::RATE_HZ;
use crate::dictionary::POSITIONS;

/// Nothing takes pulses: they are so short that no speed of a motor is beyond them.
pub const TIMING: DriverTiming = DriverTiming {
    pulse_high: 8,
    pulse_low: 8,
    direction_setup: 0,
    direction_hold: 0,
};

/// Motor and stage. A product counts the positions of a turn in its own way, whatever the encoder of the board counts.
pub const DATA: ServoData = match POSITIONS {
    Some(positions) => ServoData {
        motor: Motor {
            counts: positions,
            ..own::DATA.motor
        },
        encoder: own::DATA.motor.counts,
        ..own::DATA
    },
    None => own::DATA,
};

/// What the tasks copy from one to the other.
pub static LINK: Link = Link::new();

/// The bridges of the motor, and what else the loops switch.
pub trait Bridges {
    /// Whether the samples are those of the time in which the lower switches are on, where the
    /// converters are started at other times too.
    fn is_sampled(&self) -> bool {
        true
    }

    /// The widths that act from the bottom of the count on.
    fn put(&mut self, widths: Widths);

    /// All switches are off until there are widths.
    fn off(&mut self);

    /// The share of the time for which a brake resistor burns.
    fn burn(&mut self, share: f32) {
        let _ = share;
    }
}

/// What the current interrupt has, and nobody else: the loops, the converters and the bridges.
struct Inner {
    current: servo::Current,
    converters: converters::Currents,
    bridges: own::Bridges,
}

/// The loops above the current run as often as refills come.
const _: () = assert!(
    pwm::HZ == RATE_HZ * Selected::REFILLS * own::DATA.stage.control as u32,
    "a refill in each period of the loops above the current"
);

/// In the memory of the core alone, where it takes no turns with the instructions of the interrupt.
#[link_section = ".uninit.streamed"]
static mut INNER: MaybeUninit<Inner> = MaybeUninit::uninit();

/// The loops, with the converters and with bridges that are made last: they bring the first
/// interrupt, which waits until all is set up. Called once, by a board with interrupts off, once
/// the encoder counts.
pub fn start(
    converters: converters::Currents,
    bridges: impl FnOnce() -> own::Bridges,
) -> (Orders, LinkedServoObjects) {
    let timer = encoder::count();
    let Ok(loops) = Loops::new(&DATA, timer, None) else {
        panic!("the motor of the board cannot be one");
    };
    let inner = Inner {
        current: servo::Current::new(loops, &LINK, TIMERS_HZ),
        converters,
        bridges: bridges(),
    };
    // SAFETY: converters and bridges exist once, so this function is called once, and the interrupt
    // that has the memory from then on has not come yet.
    unsafe { (*addr_of_mut!(INNER)).write(inner) };
    let objects = LinkedServoObjects {
        link: &LINK,
        objects: servo::ServoObjects::default(),
        motor: Port::rated(&DATA.motor),
    };
    let port = Port::new(&LINK, chip::ticks(), timer);
    let port = port
        .with_counts(own::DATA.motor.counts, DATA.motor.counts)
        .with_motor(&DATA.motor);
    (Orders(port), objects)
}

/// See [`Board::on_current`].
pub fn on_current() {
    // SAFETY: it was written before interrupts were on, and this interrupt alone, which does not
    // interrupt itself, has it since.
    let inner = unsafe { (*addr_of_mut!(INNER)).assume_init_mut() };
    if !inner.bridges.is_sampled() {
        inner.converters.pass();
    } else {
        on_samples(inner);
    }
}

/// Apart, as it saves registers that the other interrupt spares itself. In RAM (memory.x), with what it calls in each period put into it.
#[inline(never)]
#[link_section = ".current"]
fn on_samples(inner: &mut Inner) {
    let counts = inner.converters.read(encoder::count());
    match inner.current.period(&counts) {
        Some(widths) => inner.bridges.put(widths),
        None => inner.bridges.off(),
    }
    if !inner.current.control(&counts, chip::ticks()) {
        inner.bridges.off();
    }
    if let Some(share) = inner.current.chopping(&counts) {
        inner.bridges.burn(share);
        if let Some(timer) = own::index() {
            inner.current.loops().index(timer);
        }
        // The interrupt of a timer that is not used.
        NVIC::pend(pac::Interrupt::TIM4);
    }
}

/// See [`Board::trip`].
pub fn trip() {
    pwm::trip();
    lines::fault_seen();
}
