//! The board: STM32F405 with an 8 MHz crystal, a CAN transceiver and a step/direction power stage.
//!
//! | pin | what | |
//! |---|---|---|
//! | PB13 | step | TIM1 channel 1N, a pulse is high |
//! | PB14 | direction | TIM1 channel 2N, high is forward |
//! | PB12 | break | TIM1 break input with pull-up, low cuts step and direction off by hardware; it has no filter and the pull-up is weak: 1 to 4.7 kΩ to 3.3 V and some nF to ground outside |
//! | PA2 | enable | low is on, as most drivers have it; pull it up outside, for the time before the firmware runs |
//! | PA3 | fault | input with pull-up, low is a fault of the stage |
//! | PC0 | supply | input with pull-up, low is no supply of the stage |
//! | PA4 to PA9 | digital inputs 1 to 6 | inputs with pull-down, each edge an interrupt |
//! | PB5 to PB7, PB10 | digital outputs 1 to 4 | high is on; low from reset on |
//! | PC2 | holding brake | high opens it; low from reset on |
//! | PC4 | analogue input | 0 to 3.3 V at the pin; the divider in front of it goes into 2064h:4 |
//! | PA0, PA1, PB11 | capture 1 to 3 | TIM2 channels 1, 2 and 4 with pull-down: wired to inputs 1 to 3 they capture the position by hardware |
//! | PB0, PB1, PB15, PC3 | rotary switch ×01h | inputs with pull-up, the lowest bit first; a switch closes to ground |
//! | PC8 to PC11 | rotary switch ×10h | the same |
//! | PC1 | factory reset | input with pull-up; low for 100 ms from power-up on: what was stored is forgotten |
//! | PB8, PB9 | CAN receive, transmit | CAN1 |
//! | PC6, PC7 | green light, red light, or one with two colours | high is on |
//! | PC12 | light of the drive | high is on |
//!
//! Core 168 MHz, TIM1 168 MHz (step pulses), APB1 42 MHz (CAN), its timers 84 MHz (TIM2 counts steps, TIM3 refills, TIM5 time and the deadlines of the node).

mod converter;
mod input_lines;
mod pulse_timer;
mod stage;

use cia402::StepAxis;
use stm32f4xx_hal::gpio::{Output, Pull, Speed, PC12, PC6, PC7};
use stm32f4xx_hal::pac;
use stm32f4xx_hal::prelude::*;
use stm32f4xx_hal::rcc::{Enable, Reset};

use super::chip::lights::PinLights;
use super::chip::watchdog::Watchdog;
use super::chip::{self, can, clocks, flash, switches, CORE_HZ, TIMERS_HZ};
use super::{user_memory, Board, NoServoObjects, Parts};
use crate::control::RATE_HZ;
use crate::stepping::SharedEmitter;
pub use stage::{cut, has_power};

app! {
    device: stm32f4xx_hal::pac,
    dispatchers: [SPI1, SPI2, SPI3],
    pulses: [cut_off: TIM1_BRK_TIM9],
    edge: [edge_of_first: EXTI4, edge: EXTI9_5],
    trip: [],
    current: [],
    loops: [],
    can: [received: CAN1_RX0, sent: CAN1_TX, error: CAN1_SCE],
    refill: [refill: TIM3],
    wake: [wake: TIM5],
}

/// The board.
pub struct Stm32f405;

impl Board for Stm32f405 {
    const TICKS_PER_MICROSECOND: u32 = chip::TICKS_PER_MICROSECOND;
    const STEP_CLOCK_HZ: u32 = CORE_HZ;
    const REFILLS: u32 = 4;
    const USER_MEMORY: usize = 4_096;
    const SCOPE_WORDS: usize = 1_024;
    const SYSTEM_TIMER_HZ: u32 = CORE_HZ;

    type Axis = StepAxis<SharedEmitter>;
    type Pulses = pulse_timer::TimerPulses;
    type Steps = pulse_timer::Interrupts;
    type ServoObjects = NoServoObjects;
    type Receiver = can::Receiver;
    type Bus = can::Controller;
    type Stage = stage::StepStage;
    type InputLines = input_lines::Lines;
    type Lights = PinLights<PC6<Output>, PC7<Output>, PC12<Output>>;
    type Parameters = flash::ParameterSectors;

    type Device = pac::Peripherals;

    fn start(device: pac::Peripherals) -> Parts<Self> {
        // First of all: a crystal that does not start then means another try, not silence for ever.
        let watchdog = Watchdog::start(device.IWDG, chip::WATCHDOG_MS, &device.DBGMCU);
        let mut rcc = clocks::start(device.RCC);
        clocks::watch_supply(&device.PWR, &device.EXTI, &mut rcc);

        let a = device.GPIOA.split(&mut rcc);
        let b = device.GPIOB.split(&mut rcc);
        let c = device.GPIOC.split(&mut rcc);

        // The output register is set before the pin becomes an output: the stage never sees a pulse of "on".
        let enable = a
            .pa2
            .into_push_pull_output_in_state(stm32f4xx_hal::gpio::PinState::High);
        let stage = stage::StepStage::new(
            enable,
            a.pa3.into_pull_up_input(),
            c.pc0.into_pull_up_input(),
            c.pc2.into_push_pull_output(),
            [
                b.pb5.into_push_pull_output().erase(),
                b.pb6.into_push_pull_output().erase(),
                b.pb7.into_push_pull_output().erase(),
                b.pb10.into_push_pull_output().erase(),
            ],
            converter::Converter::new(
                device.ADC1,
                &device.ADC_COMMON,
                c.pc4.into_analog(),
                &mut rcc,
            ),
            watchdog,
        );
        let lights = PinLights::new(
            c.pc6.into_push_pull_output(),
            c.pc7.into_push_pull_output(),
            c.pc12.into_push_pull_output(),
        );

        chip::start_time(device.TIM5, &mut rcc);

        // A debugger that stops the core stops the pulses too, and the time by which they would be late.
        device
            .DBGMCU
            .apb2_fz()
            .modify(|_, w| w.dbg_tim1_stop().set_bit());
        device
            .DBGMCU
            .apb1_fz()
            .modify(|_, w| w.dbg_tim3_stop().set_bit().dbg_tim5_stop().set_bit());
        let (pulses, steps) = pulse_timer::start(
            (device.TIM1, device.TIM2, device.DMA2),
            (
                (
                    // At the lowest speed of a pin a pulse of 100 ns would hardly leave.
                    // While the timer does not drive them they are low.
                    (b.pb13.into_alternate().speed(Speed::VeryHigh)).internal_resistor(Pull::Down),
                    (b.pb14.into_alternate().speed(Speed::VeryHigh)).internal_resistor(Pull::Down),
                    b.pb12.into_alternate().internal_resistor(Pull::Up),
                ),
                (
                    a.pa0.into_alternate().internal_resistor(Pull::Down),
                    a.pa1.into_alternate().internal_resistor(Pull::Down),
                    b.pb11.into_alternate().internal_resistor(Pull::Down),
                ),
            ),
            &mut rcc,
        );

        // The interrupt between control ticks.
        pac::TIM3::enable(&mut rcc);
        pac::TIM3::reset(&mut rcc);
        let period = TIMERS_HZ / (RATE_HZ * Self::REFILLS);
        device.TIM3.psc().write(|w| w.psc().set(0));
        device
            .TIM3
            .arr()
            .write(|w| w.arr().set((period - 1) as u16));
        device.TIM3.dier().write(|w| w.uie().set_bit());
        device.TIM3.cr1().write(|w| w.cen().set_bit());

        let inputs = [
            a.pa4.into_pull_down_input().erase(),
            a.pa5.into_pull_down_input().erase(),
            a.pa6.into_pull_down_input().erase(),
            a.pa7.into_pull_down_input().erase(),
            a.pa8.into_pull_down_input().erase(),
            a.pa9.into_pull_down_input().erase(),
        ];
        let mut syscfg = device.SYSCFG.constrain(&mut rcc);
        let input_lines = input_lines::Lines::new(inputs, &mut syscfg, device.EXTI);

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

        let can_pins = (
            // At the lowest speed an edge takes a tenth of a bit of 1 Mbit/s.
            b.pb9.into_alternate().speed(Speed::High),
            // Without a transceiver the bus is recessive.
            b.pb8.into_alternate().internal_resistor(Pull::Up),
        );
        Parts {
            pulses,
            steps,
            servo_objects: NoServoObjects,
            receiver: can::Receiver,
            bus: can::Controller::new(device.CAN1, can_pins, &mut rcc),
            stage,
            lights,
            input_lines,
            parameters: flash::ParameterSectors::new(device.FLASH),
            switches: switches::read(&digits),
            factory_reset: switches::is_held(&factory_reset),
            serial_number: chip::serial_number(),
            // SAFETY: the peripherals exist once, so this function is called once.
            user_memory: unsafe { user_memory::take() },
        }
    }

    fn ticks() -> u32 {
        chip::ticks()
    }

    fn input_levels() -> u8 {
        input_lines::levels()
    }

    fn must_stop() -> bool {
        has_power() && !stage::is_well()
    }

    fn refill_done() {
        // SAFETY: writing 0 to the flag of TIM3 clears it, reading it has no effect, and nothing else touches the timer once it runs.
        unsafe {
            let timer = &*pac::TIM3::ptr();
            timer.sr().write(|w| w.uif().clear_bit());
            // The write is through before the interrupt is left, or it would come once more.
            let _ = timer.sr().read();
        }
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
