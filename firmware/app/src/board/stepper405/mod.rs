//! The board: that of `stm32f405` with two full bridges in place of the step driver: a two-phase
//! stepper with an encoder, in closed loop. What both boards have has the same pins.
//!
//! The bridges are those of a driver with a pulse width input for each of its four half bridges,
//! with dead times of its own, an enable without which all its switches are off, and a fault line:
//! a DRV8412, or one of its kind.
//!
//! | pin | what | |
//! |---|---|---|
//! | PA8, PA9 | half bridges A+ and A− | TIM1 channels 1 and 2: PWM_A and PWM_B of a DRV8412 |
//! | PA10, PA11 | half bridges B+ and B− | TIM1 channels 3 and 4: PWM_C and PWM_D |
//! | PB13 | enable | high is on: RESET_AB and RESET_CD; 10 kΩ to ground outside |
//! | PA3 | fault | input with pull-up, low is a fault of the driver, above every other interrupt |
//! | PA0, PA1 | currents of A and B | ADC2 IN0, ADC3 IN1: 10 mΩ in line with the phase behind an amplifier of 20 V/V around 1.65 V (INA240A1); a current into + makes more |
//! | PC0 | bus | ADC1 IN10, a sixteenth (15 kΩ and 1 kΩ) |
//! | PC5 | thermistor at the driver | ADC1 IN15: 10 kΩ (B = 3,434 K) to 3.3 V, 3.3 kΩ to ground |
//! | PB4, PB5, PD2 | encoder A, B, index | TIM3 channels 1 and 2; the index is digital input 6 |
//! | PA4 to PA7 | digital inputs 1 to 4 | with pull-down |
//! | PB14, PB6, PB7, PB10 | digital outputs 1 to 4 | high is on; low from reset on |
//! | PC2 | holding brake | high opens it; low from reset on |
//! | PC4 | analogue input | |
//! | PB0, PB1, PB15, PC3 | rotary switch ×01h | inputs with pull-up, the lowest bit first; a switch closes to ground |
//! | PC8 to PC11 | rotary switch ×10h | the same |
//! | PC1 | factory reset | input with pull-up; low for 100 ms from power-up on: what was stored is forgotten |
//! | PB8, PB9 | CAN receive, transmit | CAN1 |
//! | PC6, PC7, PC12 | green light, red light, light of the drive | high is on |
//!
//! Of this package all pins of TIM1's channels are at PA8 to PA11, so what `stm32f405` has there,
//! inputs 5 and 6, lies elsewhere or nowhere; its outputs 1 and 2 make way for the encoder and PB5.
//!
//! Core 168 MHz, TIM1 168 MHz, APB1 42 MHz (CAN), its timers 84 MHz (TIM3 encoder, TIM5 time and
//! the deadlines of the node).

mod bridges;
mod motor;

use cia402::ServoAxis;
use motion::DriverTiming;
use stm32f4xx_hal::gpio::{Alternate, Output, PinState, Pull, Speed};
use stm32f4xx_hal::gpio::{PA10, PA11, PA8, PA9, PC12, PC6, PC7};
use stm32f4xx_hal::pac;
use stm32f4xx_hal::prelude::*;

use super::chip::lights::PinLights;
use super::chip::watchdog::Watchdog;
use super::chip::{self, can, clocks, flash, ram_code, switches, CORE_HZ, TIMERS_HZ};
use super::servo_stage::{self, converters, encoder, lines, orders, stage};
use super::{user_memory, Board, Parts};
use crate::stepping::SharedEmitter;
pub use bridges::{cut, gates_off, gates_on, has_power, Brake, Bridges, DEAD, TOP};
pub use motor::{three_currents, CHANNELS, DATA};

/// Its index is at no channel of the timer: an interrupt that reads the count would be late by more than counts that are lost.
pub const fn index() -> Option<u16> {
    None
}

app! {
    device: stm32f4xx_hal::pac,
    dispatchers: [SPI1, SPI2, USART1],
    pulses: [],
    edge: [edge: EXTI2],
    trip: [trip: EXTI3],
    current: [current: ADC],
    loops: [loops: TIM7],
    can: [received: CAN1_RX0, sent: CAN1_TX, error: CAN1_SCE],
    refill: [refill: TIM4],
    wake: [wake: TIM5],
}

/// The board.
pub struct Stepper405;

/// The bits of inputs 1 to 4, PA4 to PA7, of the index, PD2, and of the fault, PA3, in their
/// registers.
const FIRST: u32 = 4;
const PLAIN: u32 = 0xF;
const INDEX: u32 = 1 << 2;
pub const FAULT_LINE: u32 = 1 << 3;

impl Board for Stepper405 {
    const TICKS_PER_MICROSECOND: u32 = chip::TICKS_PER_MICROSECOND;
    const STEP_CLOCK_HZ: u32 = TIMERS_HZ;
    const REFILLS: u32 = 4;
    const USER_MEMORY: usize = 4_096;
    const SCOPE_WORDS: usize = 1_024;
    const SYSTEM_TIMER_HZ: u32 = CORE_HZ;
    const TIMING: DriverTiming = servo_stage::TIMING;

    type Axis = ServoAxis<SharedEmitter>;
    type Pulses = orders::Orders;
    type Steps = encoder::EncoderEdges;
    type ServoObjects = orders::LinkedServoObjects;
    type Receiver = can::Receiver;
    type Bus = can::Controller;
    type Stage = stage::ServoStage<bridges::Driver, 4>;
    type InputLines = lines::Lines;
    type Lights = PinLights<PC6<Output>, PC7<Output>, PC12<Output>>;
    type Parameters = flash::ParameterSectors;

    type Device = pac::Peripherals;

    fn start(device: pac::Peripherals) -> Parts<Self> {
        // First of all: a crystal that does not start then means another try, not silence for ever.
        let watchdog = Watchdog::start(device.IWDG, chip::WATCHDOG_MS, &device.DBGMCU);
        let mut rcc = clocks::start(device.RCC);
        clocks::watch_supply(&device.PWR, &device.EXTI, &mut rcc);
        ram_code::start(&device.SYSCFG, &mut rcc);

        let a = device.GPIOA.split(&mut rcc);
        let b = device.GPIOB.split(&mut rcc);
        let c = device.GPIOC.split(&mut rcc);
        let d = device.GPIOD.split(&mut rcc);

        // The output register is set before the pin becomes an output.
        let enable = b.pb13.into_push_pull_output_in_state(PinState::Low);
        let mut fault = a.pa3.into_pull_up_input();
        let brake = c.pc2.into_push_pull_output();
        let outputs = [
            b.pb14.into_push_pull_output().erase(),
            b.pb6.into_push_pull_output().erase(),
            b.pb7.into_push_pull_output().erase(),
            b.pb10.into_push_pull_output().erase(),
        ];
        let _ = [
            a.pa4.into_pull_down_input().erase(),
            a.pa5.into_pull_down_input().erase(),
            a.pa6.into_pull_down_input().erase(),
            a.pa7.into_pull_down_input().erase(),
        ];
        let lights = PinLights::new(
            c.pc6.into_push_pull_output(),
            c.pc7.into_push_pull_output(),
            c.pc12.into_push_pull_output(),
        );

        chip::start_time(device.TIM5, &mut rcc);
        // A debugger that stops the core stops the pulses: all lower switches are on, and no
        // current rises.
        device
            .DBGMCU
            .apb2_fz()
            .modify(|_, w| w.dbg_tim1_stop().set_bit());
        device
            .DBGMCU
            .apb1_fz()
            .modify(|_, w| w.dbg_tim5_stop().set_bit());

        let encoder_lines = (
            b.pb4.into_alternate().internal_resistor(Pull::Up),
            b.pb5.into_alternate().internal_resistor(Pull::Up),
        );
        encoder::start(&device.TIM3, encoder_lines, &mut rcc);
        let mut syscfg = device.SYSCFG.constrain(&mut rcc);
        let mut index = d.pd2.into_pull_down_input();
        let input_lines = lines::Lines::new(&mut index, &mut fault, &mut syscfg, device.EXTI);

        let _ = (
            c.pc0.into_analog(),
            a.pa0.into_analog(),
            a.pa1.into_analog(),
        );
        let (converters, slow) = converters::start(
            (device.ADC1, device.ADC2, device.ADC3),
            &device.ADC_COMMON,
            &CHANNELS,
            (c.pc4.into_analog(), c.pc5.into_analog()),
            &mut rcc,
        );

        let digits = [
            b.pb0.into_pull_up_input().erase(),
            b.pb1.into_pull_up_input().erase(),
            b.pb15.into_pull_up_input().erase(),
            c.pc3.into_pull_up_input().erase(),
            c.pc8.into_pull_up_input().erase(),
            c.pc9.into_pull_up_input().erase(),
            c.pc10.into_pull_up_input().erase(),
            c.pc11.into_pull_up_input().erase(),
        ];
        let factory_reset = c.pc1.into_pull_up_input().erase();
        let switches = switches::read(&digits);
        let factory_reset = switches::is_held(&factory_reset);

        // While the timer does not drive them they are low.
        let _: BridgePins = (
            (a.pa8.into_alternate().speed(Speed::High)).internal_resistor(Pull::Down),
            (a.pa9.into_alternate().speed(Speed::High)).internal_resistor(Pull::Down),
            (a.pa10.into_alternate().speed(Speed::High)).internal_resistor(Pull::Down),
            (a.pa11.into_alternate().speed(Speed::High)).internal_resistor(Pull::Down),
        );
        let (orders, servo_objects) =
            servo_stage::start(converters, Brake, || Bridges::new(device.TIM1, &mut rcc));

        let can_pins = (
            // At the lowest speed an edge takes a tenth of a bit of 1 Mbit/s.
            b.pb9.into_alternate().speed(Speed::High),
            // Without a transceiver the bus is recessive.
            b.pb8.into_alternate().internal_resistor(Pull::Up),
        );
        let driver = bridges::Driver::new(enable, fault);
        Parts {
            pulses: orders,
            steps: encoder::EncoderEdges,
            servo_objects,
            receiver: can::Receiver,
            bus: can::Controller::new(device.CAN1, can_pins, &mut rcc),
            stage: stage::ServoStage::new(driver, brake.erase(), outputs, slow, watchdog),
            lights,
            input_lines,
            parameters: flash::ParameterSectors::new(device.FLASH),
            switches,
            factory_reset,
            serial_number: chip::serial_number(),
            // SAFETY: the peripherals exist once, so this function is called once.
            user_memory: unsafe { user_memory::take() },
        }
    }

    fn ticks() -> u32 {
        chip::ticks()
    }

    fn input_levels() -> u8 {
        // SAFETY: reading the input registers has no effect.
        let (a, d) = unsafe {
            (
                (*pac::GPIOA::ptr()).idr().read().bits(),
                (*pac::GPIOD::ptr()).idr().read().bits(),
            )
        };
        let index = if d & INDEX != 0 { lines::INPUT_6 } else { 0 };
        (a >> FIRST & PLAIN) as u8 | index
    }

    // What is pended is served.
    fn refill_done() {}

    fn on_current() {
        servo_stage::on_current();
    }

    fn on_loops() {
        servo_stage::on_loops();
    }

    fn trip() {
        servo_stage::trip();
    }

    fn wake_in(microseconds: u32) {
        chip::wake_in(microseconds);
    }

    fn woken() {
        chip::woken();
    }

    fn idle() {
        chip::idle();
    }
}

/// Those of TIM1.
type BridgePins = (
    PA8<Alternate<1>>,
    PA9<Alternate<1>>,
    PA10<Alternate<1>>,
    PA11<Alternate<1>>,
);
