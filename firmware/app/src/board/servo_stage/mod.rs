//! What the boards with a servo share: TIM1 with the bridges of the motor, the encoder at TIM3, and
//!
//! | interrupt | priority | does | pended by |
//! |---|---|---|---|
//! | fault line | 8 | [`trip`] | |
//! | ADC | 7 | [`on_current`]: samples to widths | the converters, in each period |
//! | TIM7 | 6 | [`on_loops`]: what is above the current, the brake resistor, the index | that one, once in a period of the control |
//! | TIM4 | 4 | the refill: orders | that one |
//! | SysTick | 3 | the control tick, with its end of the link | |
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
use cortex_m::register::basepri;
use motion::DriverTiming;
use runtime::servo::{self, Current, CurrentLock, Link, LinkedLoops, Loops, Port, ServoData};
use stm32f4xx_hal::pac;

use ::servo::Motor;

use self::orders::{LinkedServoObjects, Orders};
use super::chip::{self, TIMERS_HZ};
use super::own;
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

/// The bridges of the motor.
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
}

/// What burns what comes back from the motor.
pub trait Brake {
    /// The share of the time for which it is on.
    fn burn(&mut self, share: f32);
}

/// What the current interrupt has.
struct OfCurrent {
    current: Current,
    converters: converters::Currents,
    bridges: own::Bridges,
}

/// What the interrupt of the loops has, and nobody else.
struct OfLoops {
    loops: LinkedLoops,
    brake: own::Brake,
    current: Masked,
}

/// In the memory of the core alone, where it takes no turns with the instructions of the interrupt.
#[link_section = ".uninit.streamed"]
static mut OF_CURRENT: MaybeUninit<OfCurrent> = MaybeUninit::uninit();
static mut OF_LOOPS: MaybeUninit<OfLoops> = MaybeUninit::uninit();

/// The current interrupt, with the converters and with bridges that are made last: they bring the
/// first interrupt, which waits until all is set up. Called once, by a board with interrupts off,
/// once the encoder counts.
pub fn start(
    converters: converters::Currents,
    brake: own::Brake,
    bridges: impl FnOnce() -> own::Bridges,
) -> (Orders, LinkedServoObjects) {
    let timer = encoder::count();
    let (Ok(current), Ok(loops)) = (Current::new(&DATA, timer, None), Loops::new(&DATA)) else {
        panic!("the motor of the board cannot be one");
    };
    let of_loops = OfLoops {
        loops: LinkedLoops::new(loops, &LINK, TIMERS_HZ),
        brake,
        current: Masked(()),
    };
    let of_current = OfCurrent {
        current,
        converters,
        bridges: bridges(),
    };
    // SAFETY: converters, brake and bridges exist once, so this function is called once, and the
    // interrupts that have the memory from then on have not come yet.
    unsafe {
        (*addr_of_mut!(OF_LOOPS)).write(of_loops);
        (*addr_of_mut!(OF_CURRENT)).write(of_current);
    }
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

/// See [`super::Board::on_current`].
pub fn on_current() {
    // SAFETY: it was written before interrupts were on. This interrupt does not interrupt itself,
    // and the loops come to the memory only while it is masked.
    let of_current = unsafe { (*addr_of_mut!(OF_CURRENT)).assume_init_mut() };
    if !of_current.bridges.is_sampled() {
        of_current.converters.pass();
    } else {
        on_samples(of_current);
    }
}

/// Apart, as it saves registers that the other interrupt spares itself. In RAM (memory.x), with what it calls in each period put into it.
#[inline(never)]
#[link_section = ".current"]
fn on_samples(of_current: &mut OfCurrent) {
    let counts = of_current.converters.read(encoder::count());
    match of_current.current.period(&counts) {
        Some(widths) => of_current.bridges.put(widths),
        None => of_current.bridges.off(),
    }
    if of_current.current.is_due() {
        // The interrupt of a timer that is not used.
        NVIC::pend(pac::Interrupt::TIM7);
    }
}

/// The priority of the current interrupt, as `app.rs` has it.
const CURRENT: u8 = 7;

/// In BASEPRI it keeps back the current interrupt and all below it. A fault of the gate driver comes
/// all the same.
const MASK: u8 = ((1 << pac::NVIC_PRIO_BITS) - CURRENT) << (8 - pac::NVIC_PRIO_BITS);

/// The way of the loops to what the current interrupt has. There is one, and the interrupt of the
/// loops has it. What is done there is a copy, or a change of some numbers, so the interrupt is late
/// by no more than that; its widths are due half a period later.
struct Masked(());

impl CurrentLock for Masked {
    #[inline]
    fn lock<R>(&mut self, f: impl FnOnce(&mut Current) -> R) -> R {
        let before = basepri::read();
        // SAFETY: more is masked than before, and below as much as before.
        unsafe { basepri::write(MASK) };
        // SAFETY: it was written before interrupts were on. The current interrupt is masked, and the
        // one of the loops is here: while `f` has `self` it cannot be called again.
        let of_current = unsafe { (*addr_of_mut!(OF_CURRENT)).assume_init_mut() };
        let result = f(&mut of_current.current);
        if of_current.current.is_off() {
            of_current.bridges.off();
        }
        // SAFETY: nobody has the memory any more.
        unsafe { basepri::write(before) };
        result
    }
}

/// See [`super::Board::on_loops`].
pub fn on_loops() {
    // SAFETY: it was written before interrupts were on, and this interrupt alone, which does not
    // interrupt itself, has it since.
    let of_loops = unsafe { (*addr_of_mut!(OF_LOOPS)).assume_init_mut() };
    let OfLoops {
        loops,
        brake,
        current,
    } = of_loops;
    let state = loops.run(current, chip::ticks());
    brake.burn(loops.chopping(&state));
    if let Some(timer) = own::index() {
        current.lock(|current| current.index(timer));
    }
    loops.tell(current, &state);
    // The interrupt of another one.
    NVIC::pend(pac::Interrupt::TIM4);
}

/// See [`super::Board::trip`].
pub fn trip() {
    pwm::trip();
    lines::fault_seen();
}
