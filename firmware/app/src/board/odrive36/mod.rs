//! The board: ODrive v3.6 for 56 V, or a clone of it, axis M0. STM32F405 with an 8 MHz crystal, CAN transceiver, three half bridges behind a gate driver DRV8301, and a half
//! bridge for a brake resistor.
//!
//! | pin | what | |
//! |---|---|---|
//! | PA8, PA9, PA10 | upper switches of phases A, B, C | TIM1 channels 1 to 3 |
//! | PB13, PB14, PB15 | lower switches | TIM1 channels 1N to 3N |
//! | PC0, PC1 | currents of B and C | ADC2 IN10, ADC3 IN11: shunts at the lower switches, behind amplifiers of the gate driver |
//! | PA6 | bus | ADC1 IN6, a nineteenth |
//! | PC5 | thermistor of the stage | ADC1 IN15 |
//! | PB12 | enable of both gate drivers | high is on |
//! | PD2 | fault of both gate drivers | low is a fault, above every other interrupt |
//! | PC10, PC11, PC12 | SPI3: clock, data in, data out | |
//! | PC13, PC14 | chip selects of the gate drivers of M0 and M1 | M1's stays high |
//! | PB4, PB5, PC9 | encoder A, B, index | TIM3 channels 1, 2 and 4; the index is digital input 6 too |
//! | PB10, PB11 | lower and upper switch of AUX | TIM2 channels 3 and 4: a brake resistor from AUX to ground |
//! | PC6, PC7, PC8, PA7, PB0, PB1 | switches of M1 | low: all off |
//! | PA0 to PA3 | GPIO 1 to 4: digital inputs 1 to 4 | with pull-down |
//! | PC4 | GPIO 5: analogue input | |
//! | PB2 | GPIO 6: holding brake | high opens it |
//! | PA15, PB3 | GPIO 7 and 8: green light, red light | high is on |
//! | PB8, PB9 | CAN receive, transmit | CAN1 |
//!
//! From the firmware of its maker, of public repositories (github.com/odriverobotics/ODrive): pins from `Firmware/Board/v3/Inc/main.h`; timers and their channels from
//! `Src/tim.c` there, converters and their channels from `Src/adc.c`, SPI from `Src/spi.c`; shunts and the divider of the bus from `Inc/board.h`. That a current into the motor makes more counts is how
//! that firmware takes it (`MotorControl/low_level.cpp`). Nothing of it has been tried on a real board.
//!
//! Core 168 MHz, TIM1 168 MHz, APB1 42 MHz (CAN, SPI3), its timers 84 MHz (TIM2 brake, TIM3 encoder, TIM5 time and the deadlines of the node).

mod gates;
mod motor;
mod pwm;

use canopen::settings::Wish;
use cia402::ServoAxis;
use motion::DriverTiming;
use runtime::Lights;
use stm32f4xx_hal::gpio::{ErasedPin, Output, PinState, Pull, Speed};
use stm32f4xx_hal::pac;
use stm32f4xx_hal::prelude::*;

use super::chip::watchdog::Watchdog;
use super::chip::{self, can, clocks, flash, ram_code, CORE_HZ, TIMERS_HZ};
pub use super::servo_stage::encoder::index;
use super::servo_stage::{self, converters, encoder, lines, orders, stage};
use super::{user_memory, Board, Parts};
use crate::stepping::SharedEmitter;
pub use motor::{three_currents, CHANNELS, DATA};
pub use pwm::{cut, Brake, Bridges, DEAD, TOP};
pub use servo_stage::pwm::{
    are_outputs_on as has_power, outputs_off as gates_off, outputs_on as gates_on,
};

app! {
    device: stm32f4xx_hal::pac,
    dispatchers: [SPI1, SPI2, USART1],
    pulses: [],
    edge: [edge: EXTI9_5],
    trip: [trip: EXTI2],
    current: [current: ADC],
    loops: [loops: TIM7],
    can: [received: CAN1_RX0, sent: CAN1_TX, error: CAN1_SCE],
    refill: [refill: TIM4],
    wake: [wake: TIM5],
}

/// The board.
pub struct Odrive36;

/// The bits of inputs 1 to 4, PA0 to PA3, of the index, PC9, and of nFAULT, PD2, in their registers.
const PLAIN: u32 = 0xF;
const INDEX: u32 = 1 << 9;
pub const FAULT_LINE: u32 = 1 << 2;

impl Board for Odrive36 {
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
    type Stage = stage::ServoStage<gates::Gates, 0>;
    type InputLines = lines::Lines;
    type Lights = TwoLights;
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

        // The output registers are set before the pins become outputs. All switches of M1 are off for ever.
        let enable = b.pb12.into_push_pull_output_in_state(PinState::Low);
        let select = c.pc13.into_push_pull_output_in_state(PinState::High);
        let _ = c.pc14.into_push_pull_output_in_state(PinState::High);
        let _ = [
            c.pc6.into_push_pull_output().erase(),
            c.pc7.into_push_pull_output().erase(),
            c.pc8.into_push_pull_output().erase(),
            a.pa7.into_push_pull_output().erase(),
            b.pb0.into_push_pull_output().erase(),
            b.pb1.into_push_pull_output().erase(),
        ];
        let _ = [
            a.pa0.into_pull_down_input().erase(),
            a.pa1.into_pull_down_input().erase(),
            a.pa2.into_pull_down_input().erase(),
            a.pa3.into_pull_down_input().erase(),
        ];
        let mut fault = d.pd2.into_pull_up_input();
        let brake = b.pb2.into_push_pull_output();
        let lights = TwoLights {
            run: a.pa15.into_push_pull_output().erase(),
            error: b.pb3.into_push_pull_output().erase(),
        };

        chip::start_time(device.TIM5, &mut rcc);
        // A debugger that stops the core stops the pulses at the place where they are: the switches go off.
        device
            .DBGMCU
            .apb2_fz()
            .modify(|_, w| w.dbg_tim1_stop().set_bit());
        device
            .DBGMCU
            .apb1_fz()
            .modify(|_, w| w.dbg_tim2_stop().set_bit().dbg_tim5_stop().set_bit());

        let encoder_lines = (
            b.pb4.into_alternate().internal_resistor(Pull::Up),
            b.pb5.into_alternate().internal_resistor(Pull::Up),
        );
        encoder::start(&device.TIM3, encoder_lines, &mut rcc);
        let mut syscfg = device.SYSCFG.constrain(&mut rcc);
        let mut index = c.pc9.into_pull_down_input();
        let input_lines = lines::Lines::new(&mut index, &mut fault, &mut syscfg, device.EXTI);
        // Its edges and its level are seen all the same.
        let index = index.into_alternate().internal_resistor(Pull::Down);
        encoder::start_index(&device.TIM3, index);

        let words = gates::Words::new(
            device.SPI3,
            (
                c.pc10.into_alternate().speed(Speed::High),
                c.pc11.into_alternate().internal_resistor(Pull::Up),
                c.pc12.into_alternate().speed(Speed::High),
            ),
            select,
            &mut rcc,
        );
        let _ = (
            a.pa6.into_analog(),
            c.pc0.into_analog(),
            c.pc1.into_analog(),
        );
        let (converters, slow) = converters::start(
            (device.ADC1, device.ADC2, device.ADC3),
            &device.ADC_COMMON,
            &CHANNELS,
            (c.pc4.into_analog(), c.pc5.into_analog()),
            &mut rcc,
        );
        let gates = gates::Gates::new(words, enable, fault);

        // While a timer does not drive them the switches are off.
        let _: BridgePins = (
            (a.pa8.into_alternate().speed(Speed::High)).internal_resistor(Pull::Down),
            (a.pa9.into_alternate().speed(Speed::High)).internal_resistor(Pull::Down),
            (a.pa10.into_alternate().speed(Speed::High)).internal_resistor(Pull::Down),
            (b.pb13.into_alternate().speed(Speed::High)).internal_resistor(Pull::Down),
            (b.pb14.into_alternate().speed(Speed::High)).internal_resistor(Pull::Down),
            (b.pb15.into_alternate().speed(Speed::High)).internal_resistor(Pull::Down),
            (b.pb10.into_alternate().speed(Speed::High)).internal_resistor(Pull::Down),
            (b.pb11.into_alternate().speed(Speed::High)).internal_resistor(Pull::Down),
        );
        let brake_resistor = Brake::new(device.TIM2, &mut rcc);
        let (orders, servo_objects) = servo_stage::start(converters, brake_resistor, || {
            Bridges::new(device.TIM1, &mut rcc)
        });

        let can_pins = (
            // At the lowest speed an edge takes a tenth of a bit of 1 Mbit/s.
            b.pb9.into_alternate().speed(Speed::High),
            // Without a transceiver the bus is recessive.
            b.pb8.into_alternate().internal_resistor(Pull::Up),
        );
        Parts {
            pulses: orders,
            steps: encoder::EncoderEdges,
            servo_objects,
            receiver: can::Receiver,
            bus: can::Controller::new(device.CAN1, can_pins, &mut rcc),
            stage: stage::ServoStage::new(gates, brake.erase(), [], slow, watchdog),
            lights,
            input_lines,
            parameters: flash::ParameterSectors::new(device.FLASH),
            // It has none that are free.
            switches: Wish::NOTHING,
            factory_reset: false,
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
        let (a, c) = unsafe {
            (
                (*pac::GPIOA::ptr()).idr().read().bits(),
                (*pac::GPIOC::ptr()).idr().read().bits(),
            )
        };
        let index = if c & INDEX != 0 { lines::INPUT_6 } else { 0 };
        (a & PLAIN) as u8 | index
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

/// Those of TIM1, upper and lower switches, and of TIM2, lower and upper.
type BridgePins = (
    stm32f4xx_hal::gpio::PA8<stm32f4xx_hal::gpio::Alternate<1>>,
    stm32f4xx_hal::gpio::PA9<stm32f4xx_hal::gpio::Alternate<1>>,
    stm32f4xx_hal::gpio::PA10<stm32f4xx_hal::gpio::Alternate<1>>,
    stm32f4xx_hal::gpio::PB13<stm32f4xx_hal::gpio::Alternate<1>>,
    stm32f4xx_hal::gpio::PB14<stm32f4xx_hal::gpio::Alternate<1>>,
    stm32f4xx_hal::gpio::PB15<stm32f4xx_hal::gpio::Alternate<1>>,
    stm32f4xx_hal::gpio::PB10<stm32f4xx_hal::gpio::Alternate<1>>,
    stm32f4xx_hal::gpio::PB11<stm32f4xx_hal::gpio::Alternate<1>>,
);

/// The green and the red light; there is no third pin for that of the drive.
pub struct TwoLights {
    run: ErasedPin<Output>,
    error: ErasedPin<Output>,
}

impl Lights for TwoLights {
    const BICOLOUR: bool = false;

    fn set_run(&mut self, on: bool) {
        self.run.set_state(on.into());
    }

    fn set_error(&mut self, on: bool) {
        self.error.set_state(on.into());
    }

    fn set_drive(&mut self, _on: bool) {}
}
