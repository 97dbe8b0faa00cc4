//! The emulator: QEMU's machine `mps2-an386`, Arm's board MPS2 with a Cortex-M4F and the peripherals of the CMSDK: another chip than those of the other
//! boards, with its own interrupts, timers and memory ([`device`]). It has no CAN and no flash.
//!
//! CAN frames travel as lines of SLCAN over UART0, which the emulator serves on a TCP port. Parameters lie in a file of the
//! host. Step pulses go nowhere, but they are timed and counted as on a board; a file of the host may tell which inputs they move along
//! the axis. There is no mass, no end stop and no driver that feels one. All times are the emulator's virtual time.

#[allow(dead_code, reason = "a chip has more than a firmware takes")]
mod device;
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

use canopen::settings::Wish;
use cia402::StepAxis;
use motion::step_interrupt;
use runtime::Lights;

use super::{user_memory, Board, NoServoObjects, Parts, Stage};
use crate::control::{RATE_HZ, TIMING};
use crate::stepping::SharedEmitter;

app! {
    device: crate::board::qemu::device,
    dispatchers: [PORT1, I2S, TSC],
    pulses: [step: TIMER0],
    edge: [edge: PORT0],
    trip: [],
    current: [],
    loops: [],
    can: [received: UART0RX],
    refill: [refill: TIMER1],
    wake: [wake: DUALTIMER],
}

/// The emulated board.
pub struct Qemu;

/// What the control tick and the step interrupt share.
static mut STEPS: step_interrupt::Shared = step_interrupt::Shared::new();

impl Board for Qemu {
    const TICKS_PER_MICROSECOND: u32 = device::CLOCK_HZ / 1_000_000;
    const STEP_CLOCK_HZ: u32 = device::CLOCK_HZ;
    const SYSTEM_TIMER_HZ: u32 = device::CLOCK_HZ;
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

    type Device = device::Peripherals;

    fn start(_device: device::Peripherals) -> Parts<Self> {
        // SAFETY: the board starts once, so this function is called once, and nobody else names the memory.
        let shared = unsafe { &mut *addr_of_mut!(STEPS) };
        let (queue, player) = step_interrupt::split(shared, step_timer::AlarmTimer, TIMING);
        wake_timer::start();
        refill_timer::start(Self::STEP_CLOCK_HZ / RATE_HZ / Self::REFILLS);
        Parts {
            pulses: pulses::InterruptPulses(queue),
            steps: pulses::StepPlayer {
                player,
                axis: inputs::Axis::open(),
            },
            servo_objects: NoServoObjects,
            receiver: serial::Receiver::new(),
            bus: serial::SerialBus::new(),
            stage: IdealStage,
            lights: NoLights,
            input_lines: inputs::Lines,
            parameters: parameter_file::ParameterFile::open(),
            // The firmware takes no pins.
            switches: Wish::NOTHING,
            factory_reset: false,
            serial_number: 1,
            // SAFETY: as above.
            user_memory: unsafe { user_memory::take() },
        }
    }

    fn ticks() -> u32 {
        now()
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

/// The emulator's time, in clocks.
fn now() -> u32 {
    device::FPGAIO.counter.read()
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
