//! The boards the firmware runs on.
//!
//! A board is a type that implements [`Board`], in a module that makes the app of it by the macro [`app`](macro@crate::app): with its
//! peripheral access crate and the interrupts that it has. The feature of the same name makes it [`Selected`], and nothing outside of
//! its module names its chip. What a port consists of is in `docs/hardware.md`.
//!
//! Of the firmware this folder is the only place with `unsafe` code (RTIC's own among it) and the only one that touches peripherals. The two other images have some of their own: `bin/bench`
//! handles the hard fault, `bin/no_panic.rs` has cells the compiler cannot see through
//! and the function that does not exist.

use canopen::settings::Wish;
use cia402::{Behaves, RatedMotor, ServoOrder, ServoReport};
use embedded_storage::nor_flash::NorFlash;

use crate::control::{Moving, TIMING};
use crate::machine::UserMemory;
use motion::{DriverTiming, PulseSink};
use runtime::{Controller, Inbox, Lights};

#[cfg(feature = "rtt")]
use defmt_rtt as _;

#[cfg(feature = "stm32f4")]
mod chip;
mod control_timer;
#[cfg(not(feature = "rtt"))]
mod no_log;
#[cfg(feature = "odrive36")]
mod odrive36;
#[cfg(feature = "qemu")]
mod qemu;
mod scope_memory;
#[cfg(any(feature = "odrive36", feature = "stepper405"))]
mod servo_stage;
#[cfg(feature = "stepper405")]
mod stepper405;
#[cfg(feature = "stm32f405")]
mod stm32f405;
mod user_memory;

pub use control_timer::ControlTimer;
#[cfg(feature = "odrive36")]
use odrive36 as own;
#[cfg(feature = "odrive36")]
pub use odrive36::Odrive36 as Selected;
#[cfg(feature = "qemu")]
pub use qemu::Qemu as Selected;
pub use scope_memory::SCOPE_MEMORY;
#[cfg(feature = "stepper405")]
use stepper405 as own;
#[cfg(feature = "stepper405")]
pub use stepper405::Stepper405 as Selected;
#[cfg(feature = "stm32f405")]
use stm32f405 as own;
#[cfg(feature = "stm32f405")]
pub use stm32f405::Stm32f405 as Selected;

const BOARDS: usize = cfg!(feature = "stm32f405") as usize
    + cfg!(feature = "stepper405") as usize
    + cfg!(feature = "odrive36") as usize
    + cfg!(feature = "qemu") as usize;

const _: () = assert!(
    BOARDS == 1,
    "exactly one of the features `stm32f405`, `stepper405`, `odrive36` and `qemu` chooses the board"
);

/// What the firmware needs of a board.
pub trait Board: Sized {
    /// Counts of [`Board::ticks`] in a microsecond.
    const TICKS_PER_MICROSECOND: u32;
    /// Counts of the step timer in a second.
    const STEP_CLOCK_HZ: u32;
    /// How often in a control tick pulses are committed. If more than once, [`Board::refill_done`] belongs to the interrupt that
    /// comes as often.
    const REFILLS: u32;
    /// Counts of the system timer in a second.
    const SYSTEM_TIMER_HZ: u32;
    /// The longest value of object 2020h "User memory", in bytes. There is room for two of them if the data sheet lists it.
    const USER_MEMORY: usize;
    /// What the step driver asks for.
    const TIMING: DriverTiming = TIMING;
    /// Words of samples that the scope has room for, if the data sheet lists it.
    const SCOPE_WORDS: usize;

    /// What moves the motor.
    type Axis: Moving;
    /// Where the control tick puts step pulses in, or the orders to a servo.
    type Pulses: Pulses + Send;
    /// What step pulses and captured positions need of an interrupt.
    type Steps: Steps + Send;
    /// What a servo has beside its orders.
    type ServoObjects: ServoObjects + Send;
    /// The interrupts of the CAN controller.
    type Receiver: Receive<Self::Bus> + Send;
    /// The CAN controller.
    type Bus: Controller + Send;
    /// The power stage and what watches it.
    type Stage: Stage + Send;
    /// The lights.
    type Lights: Lights + Send;
    /// The interrupt of the digital inputs.
    type InputLines: InputLines + Send;
    /// The flash sectors of the parameter store, all of them and nothing else, from address 0.
    type Parameters: NorFlash + Send;

    /// The peripherals of the chip.
    type Device;

    /// Sets up clocks and peripherals. Called once, with interrupts off. The power stage is off, the CAN controller silent
    /// until [`Controller::start`].
    fn start(device: Self::Device) -> Parts<Self>;

    /// A free-running counter of 32 bits, [`Board::TICKS_PER_MICROSECOND`] a microsecond. Any task may read it.
    fn ticks() -> u32;

    /// The levels of the digital inputs, input `n` in bit `n − 1`; 0 of those that are not there. Any task may read them.
    fn input_levels() -> u8;

    /// Whether the motor has current while its stage has lost the supply or reports a fault. Asked between control ticks, at each refill; a board
    /// that leaves all of that to the tick says no.
    fn must_stop() -> bool {
        false
    }

    /// The interrupt between two control ticks has been served.
    fn refill_done();

    /// The currents of a servo are measured: once in each period of the modulation, above everything but [`Board::trip`].
    #[allow(
        dead_code,
        reason = "a board with a step driver binds no interrupt to it"
    )]
    fn on_current() {}

    /// What is above the current of a servo: once in each period of its control, pended by [`Board::on_current`], below it and above all else.
    #[allow(
        dead_code,
        reason = "a board with a step driver binds no interrupt to it"
    )]
    fn on_loops() {}

    /// The gate driver of a servo has a fault, above everything: no current.
    #[allow(
        dead_code,
        reason = "a board with a step driver binds no interrupt to it"
    )]
    fn trip() {}

    /// Raises the wake interrupt after so many microseconds, fewer than a control tick has, in place of one that was to come.
    fn wake_in(microseconds: u32);

    /// The wake interrupt has been served.
    fn woken();

    /// What the processor does when there is nothing to do; returns at the latest with the next interrupt.
    fn idle();
}

/// What [`Board::start`] gives.
pub struct Parts<B: Board> {
    pub pulses: B::Pulses,
    pub steps: B::Steps,
    pub servo_objects: B::ServoObjects,
    pub receiver: B::Receiver,
    pub bus: B::Bus,
    pub stage: B::Stage,
    pub lights: B::Lights,
    pub input_lines: B::InputLines,
    pub parameters: B::Parameters,
    /// What the switches ask for.
    pub switches: Wish,
    /// The input for the factory reset is held.
    pub factory_reset: bool,
    /// Object 1018h:4 unless production has given another, the same at every start and different on every board.
    pub serial_number: u32,
    /// Two values of object 2020h.
    pub user_memory: [UserMemory; 2],
}

/// Where the control tick puts step pulses in, and what has become of them.
pub trait Pulses: PulseSink {
    /// Called at the start of every control tick, and of every refill.
    fn service(&mut self);

    /// The position in steps: pulses that left since the start, forward less reverse.
    fn position(&mut self) -> i64;

    /// The position in steps, modulo 2³², for what [`Steps::count`] gave a short while ago.
    fn position_at(&self, count: u32) -> i32;

    /// Drops what has not been played. A pulse that has begun counts.
    fn drop_all(&mut self);

    /// A fault of the pulses as a CiA 402 error code: the outputs were cut off by hardware.
    fn fault(&self) -> Option<u16>;

    /// The motor gets current, and nothing is played: outputs that were cut off go on, if what has cut them off is over.
    fn mend(&mut self);

    /// The motor of a servo; a board with a step driver has none, as with the next three.
    fn motor(&self) -> RatedMotor {
        RatedMotor::NONE
    }

    /// What a servo is to do from now on.
    fn order(&mut self, order: &ServoOrder) {
        let _ = order;
    }

    /// What a servo has told last.
    fn report(&self) -> ServoReport {
        ServoReport::NONE
    }

    /// The records not yet played are none any more.
    fn forget(&mut self) {}
}

/// What a servo has beside its orders: gains, data and measurements of its motor, between the dictionary and its loops.
pub trait ServoObjects {
    /// Hands on what masters have written, and shows what was found. Called behind each run of the node; a control tick may have passed since the last one.
    fn attend<D: Behaves>(
        &mut self,
        dictionary: &mut D,
        product: &mut D::Behaviour,
        has_ticked: bool,
    );
}

/// A step driver has none.
#[allow(dead_code, reason = "a board with a servo has one")]
pub struct NoServoObjects;

impl ServoObjects for NoServoObjects {
    fn attend<D: Behaves>(&mut self, _: &mut D, _: &mut D::Behaviour, _: bool) {}
}

/// The interrupts of the step pulses.
pub trait Steps {
    /// A step is due, where the timer needs help with each; or the outputs were cut off by the break input, and what makes the pulses is
    /// to stop.
    #[allow(dead_code, reason = "a board with a servo binds no interrupt to it")]
    fn on_interrupt(&mut self);

    /// What the counter of steps showed when an edge of this input came (counted from 0), as nearly as the board can tell.
    fn count(&mut self, input: usize) -> u32;
}

/// The interrupts of a CAN controller.
pub trait Receive<B> {
    /// Puts every frame that has arrived into the inbox, and takes note of what was sent and of errors.
    fn on_interrupt(&mut self, bus: &mut B, inbox: &mut Inbox);
}

/// The interrupt of the digital inputs.
pub trait InputLines {
    /// The inputs of which an edge has come since the last call, in the order of [`Board::input_levels`]. Called from the input
    /// interrupt.
    fn take(&mut self) -> u8;
}

/// The power stage of the motor, its monitors, and the watchdog over the tasks.
pub trait Stage {
    /// Whether the stage has its supply.
    fn supply(&self) -> bool;

    /// A fault of the stage as a CiA 402 error code.
    fn fault(&self) -> Option<u16>;

    /// Puts what the board measures beside supply, position and inputs into `inputs`: supply voltage, temperature, analogue input.
    /// What it does not measure it leaves alone.
    fn measure(&mut self, inputs: &mut cia402::Inputs);

    /// Current in the motor, or none.
    fn set_power(&mut self, on: bool);

    /// The digital outputs, output `n` in bit `n − 1`.
    fn set_outputs(&mut self, levels: u8);

    /// Opens the holding brake, or closes it.
    fn set_brake(&mut self, open: bool);

    /// Every task is alive.
    fn feed_watchdog(&mut self);
}
