//! The emulator: QEMU's machine `netduinoplus2`, which has an STM32F405 without CAN, pins, flash programming and PLL.
//!
//! CAN frames travel as lines of SLCAN over USART2, which the emulator serves on a TCP port. Parameters lie in a file of the
//! host. Step pulses go nowhere, but they are timed and counted as on a board; a file of the host may tell which inputs they move along
//! the axis. There is no mass, no end stop and no driver that feels one. All times are the emulator's virtual time.
//!
//! What the machine does not have must not be touched: reading the chip's unique number is a fault, and waiting for the PLL
//! never ends.

mod inputs;
mod parameter_file;
mod pulses;
mod refill_timer;
mod semihosting;
mod serial;
mod step_timer;
mod wake_timer;

use core::ptr::addr_of_mut;

use cortex_m_rt::{exception, ExceptionFrame};
use cortex_m_semihosting::{debug, heprintln};
use stm32f4xx_hal::pac;

use canopen::settings::Wish;
use cia402::StepAxis;
use motion::step_interrupt;
use runtime::Lights;

use super::{user_memory, Board, NoServoObjects, Parts, Stage};
use crate::control::{RATE_HZ, TIMING};
use crate::stepping::SharedEmitter;

app! {
    device: stm32f4xx_hal::pac,
    dispatchers: [SPI1, SPI2, SPI3],
    pulses: [step: TIM2],
    edge: [edge: EXTI9_5],
    trip: [],
    current: [],
    can: [received: USART2],
    refill: [refill: TIM3],
    wake: [wake: TIM4],
}

/// The emulated board.
pub struct Qemu;

/// What the control tick and the step interrupt share.
static mut STEPS: step_interrupt::Shared = step_interrupt::Shared::new();

impl Board for Qemu {
    const TICKS_PER_MICROSECOND: u32 = 1_000;
    const STEP_CLOCK_HZ: u32 = 1_000_000_000;
    const SYSTEM_TIMER_HZ: u32 = 168_000_000;
    const REFILLS: u32 = 4;
    const USER_MEMORY: usize = 20_480;
    const SCOPE_WORDS: usize = 5_120;

    type Axis = StepAxis<SharedEmitter>;
    type Pulses = pulses::InterruptPulses;
    type Steps = pulses::StepPlayer;
    type ServoObjects = NoServoObjects;
    type Receiver = serial::Receiver;
    type Bus = serial::SerialBus;
    type Stage = IdealStage;
    type Lights = NoLights;
    type InputLines = inputs::Lines;
    type Parameters = parameter_file::ParameterFile;

    type Device = pac::Peripherals;

    fn start(device: pac::Peripherals) -> Parts<Self> {
        let timer = step_timer::AlarmTimer::new(device.TIM2);
        // SAFETY: the peripherals exist once, so this function is called once, and nobody else names the memory.
        let shared = unsafe { &mut *addr_of_mut!(STEPS) };
        let (queue, player) = step_interrupt::split(shared, timer, TIMING);
        wake_timer::start(&device.TIM4);
        refill_timer::start(device.TIM3, Self::STEP_CLOCK_HZ / RATE_HZ / Self::REFILLS);
        Parts {
            pulses: pulses::InterruptPulses(queue),
            steps: pulses::StepPlayer {
                player,
                axis: inputs::Axis::open(),
            },
            servo_objects: NoServoObjects,
            receiver: serial::Receiver::new(),
            bus: serial::SerialBus::new(device.USART2),
            stage: IdealStage,
            lights: NoLights,
            input_lines: inputs::Lines,
            parameters: parameter_file::ParameterFile::open(),
            // The machine has no pins.
            switches: Wish::NOTHING,
            factory_reset: false,
            serial_number: 1,
            // SAFETY: the peripherals exist once, so this function is called once.
            user_memory: unsafe { user_memory::take() },
        }
    }

    fn ticks() -> u32 {
        virtual_nanoseconds()
    }

    fn input_levels() -> u8 {
        inputs::levels()
    }

    fn refill_done() {
        refill_timer::done();
    }

    fn wake_in(microseconds: u32) {
        wake_timer::wake_in(microseconds * Self::TICKS_PER_MICROSECOND);
    }

    fn woken() {
        wake_timer::woken();
    }

    fn idle() {
        // Not `wfi`: the emulator's clock keeps up with the host's only while instructions are executed.
        cortex_m::asm::nop();
    }
}

/// The emulator's time: a TIM5 that nobody ever wrote counts nanoseconds, also while it is not enabled.
fn virtual_nanoseconds() -> u32 {
    // SAFETY: reading the counter of TIM5 has no effect, and nobody writes the timer.
    unsafe { (*pac::TIM5::ptr()).cnt().read().bits() }
}

/// A power stage that always has its supply and never a fault; the watchdog is not emulated.
pub struct IdealStage;

impl Stage for IdealStage {
    fn supply(&self) -> bool {
        true
    }

    fn fault(&self) -> Option<u16> {
        None
    }

    // The machine has no converters.
    fn measure(&mut self, _inputs: &mut cia402::Inputs) {}

    fn set_power(&mut self, _on: bool) {}

    fn set_outputs(&mut self, _levels: u8) {}

    fn set_brake(&mut self, _open: bool) {}

    fn feed_watchdog(&mut self) {}
}

/// Nobody sees the lights.
pub struct NoLights;

impl Lights for NoLights {
    const BICOLOUR: bool = false;

    fn set_run(&mut self, _on: bool) {}

    fn set_error(&mut self, _on: bool) {}

    fn set_drive(&mut self, _on: bool) {}
}

/// A bug was found: the emulator ends with an error.
#[panic_handler]
fn panic(info: &core::panic::PanicInfo) -> ! {
    cortex_m::interrupt::disable();
    heprintln!("{}", info);
    end()
}

/// A fault of the processor ends the emulator like a panic.
#[exception]
unsafe fn HardFault(frame: &ExceptionFrame) -> ! {
    heprintln!("hard fault at {:#010x}", frame.pc());
    end()
}

fn end() -> ! {
    loop {
        debug::exit(debug::EXIT_FAILURE);
    }
}
