//! The firmware of the drive: its tasks, and nothing else.
//!
//! | task | priority | raised by | does |
//! |---|---|---|---|
//! | `step` | 5 | step timer | step pulses, counted, where the timer needs help with each |
//! | `pulses_broken` | 5 | break input of the step timer | stops the timer whose pulses no longer leave |
//! | `first_input`, `inputs` | 5 | an edge of a digital input | captures the position |
//! | `can_received`, `serial` | 4 | CAN controller | stamps frames and queues them |
//! | `can_sent`, `can_error` | 4 | CAN controller | room for the next frame; errors |
//! | `control` | 3 | system timer, 1 kHz or in step with SYNC | state machine, mode, planner |
//! | `stop` | 3 | `node`, for a command to stop | the control tick for it, which does not wait for the next one |
//! | `refill` | 3 | refill timer, 4 kHz | hands out pulses between control ticks |
//! | `node` | 2 | a frame, room to send, every control tick | CANopen; writes the parameter sectors |
//! | `lights` | 1 | `node`, every 50 ms | green and red light |
//!
//! A task may only be interrupted by those above it. What two of them share is locked while a snapshot is copied or a
//! frame handed over, no longer.
#![no_std]
#![no_main]
#![allow(
    missing_debug_implementations,
    reason = "nobody prints what a task owns, and the text would cost flash"
)]

mod board;
#[forbid(unsafe_code)]
mod clock;
#[forbid(unsafe_code)]
mod control;
#[forbid(unsafe_code)]
mod dictionary;
#[forbid(unsafe_code)]
mod machine;
#[forbid(unsafe_code)]
mod settings;
#[forbid(unsafe_code)]
mod share;

#[rtic::app(device = stm32f4xx_hal::pac, peripherals = true, dispatchers = [SPI1, SPI2, SPI3])]
mod app {
    use cia402::inputs::Capture;
    use cia402::Exchange;
    use embedded_storage::nor_flash::ReadNorFlash;
    use runtime::{inbox, Controller, Inbox, Lost, Node, Panel, PowerUp, Received, Signals};
    use store::Store;

    use crate::board::{
        self, Board, Bus, ControlTimer, InputLines, Parts, Receive, Selected, Steps,
    };
    use crate::clock;
    use crate::control::{Control, RATE_HZ};
    use crate::dictionary::Dictionary;
    use crate::machine::Machine;
    use crate::settings::BUILD;
    use crate::share::{Alone, Around, LockedBus};

    type Parameters = Store<<Selected as Board>::Parameters>;

    #[shared]
    struct Shared {
        exchange: Exchange,
        bus: <Selected as Board>::Bus,
        alive: bool,
        #[lock_free]
        reception: (<Selected as Board>::Receiver, Inbox),
        #[lock_free]
        control: Control,
        #[lock_free]
        node: (Node<Dictionary, Machine, Parameters>, Received),
        #[lock_free]
        step: (
            <Selected as Board>::Steps,
            <Selected as Board>::InputLines,
            &'static Capture,
        ),
    }

    #[local]
    struct Local {
        timer: ControlTimer,
        panel: Panel<<Selected as Board>::Lights>,
    }

    #[init(local = [
        frames: inbox::Memory = inbox::Memory::new(),
        lost: Lost = Lost::new(),
        edges: Capture = Capture::new(),
    ])]
    fn init(cx: init::Context) -> (Shared, Local, init::Monotonics) {
        let Parts {
            pulses,
            steps,
            receiver,
            bus,
            stage,
            lights,
            input_lines,
            parameters,
            switches,
            factory_reset,
            serial_number,
            user_memory,
        } = Selected::start(cx.device);
        cx.local.edges.begin(Selected::input_levels());

        // All of the board's sectors. They are far smaller than 4 GiB.
        let sectors = 0..parameters.capacity() as u32;
        let mut store = Store::new(parameters, sectors).ok();
        if store.is_none() {
            defmt::error!("the parameter sectors do not suit the store");
        }
        let power_up = PowerUp {
            build: BUILD,
            switches,
            factory_reset,
        };
        let bit_rates = <Selected as Board>::Bus::BIT_RATES;
        let power_on = power_up.choose(&mut store, bit_rates);

        let (inbox, received) = Inbox::new(cx.local.frames, cx.local.lost);
        let [value, spare] = user_memory;
        let machine = Machine::new(value, spare, &board::SCOPE_MEMORY);
        let mut node = Node::new(
            Dictionary::new(),
            machine,
            &power_on,
            serial_number,
            bit_rates,
            store,
        );
        let (mut exchange, mut bus) = (Alone(Exchange::new()), Alone(bus));
        let mut around = Around {
            exchange: &mut exchange,
            // Nothing moves yet.
            stop: || {},
        };
        node.power_on(&mut around, &mut LockedBus(&mut bus));
        let timer = ControlTimer::start::<Selected>(cx.core.SYST, RATE_HZ);

        let shared = Shared {
            exchange: exchange.0,
            bus: bus.0,
            alive: true,
            reception: (receiver, inbox),
            control: Control::new(
                pulses,
                stage,
                cx.local.lost,
                cx.local.edges,
                &board::SCOPE_MEMORY,
            ),
            node: (node, received),
            step: (steps, input_lines, cx.local.edges),
        };
        let local = Local {
            timer,
            panel: Panel::new(lights),
        };
        (shared, local, init::Monotonics())
    }

    #[idle]
    fn idle(_: idle::Context) -> ! {
        loop {
            Selected::idle();
        }
    }

    #[task(binds = TIM2, priority = 5, shared = [step])]
    fn step(cx: step::Context) {
        cx.shared.step.0.on_interrupt();
    }

    #[task(binds = TIM1_BRK_TIM9, priority = 5, shared = [step])]
    fn pulses_broken(cx: pulses_broken::Context) {
        cx.shared.step.0.on_break();
    }

    #[task(binds = EXTI4, priority = 5, shared = [step])]
    fn first_input(cx: first_input::Context) {
        let (steps, lines, edges) = cx.shared.step;
        let ticks = Selected::ticks();
        edges.note(
            lines.take(),
            Selected::input_levels(),
            |input| steps.count(input),
            ticks,
        );
    }

    #[task(binds = EXTI9_5, priority = 5, shared = [step])]
    fn inputs(cx: inputs::Context) {
        let (steps, lines, edges) = cx.shared.step;
        let ticks = Selected::ticks();
        edges.note(
            lines.take(),
            Selected::input_levels(),
            |input| steps.count(input),
            ticks,
        );
    }

    #[task(binds = CAN1_RX0, priority = 4, shared = [bus, reception])]
    fn can_received(mut cx: can_received::Context) {
        let (receiver, inbox) = cx.shared.reception;
        cx.shared.bus.lock(|bus| receiver.receive(bus, inbox));
        // An error says that the task is on its way already.
        node::spawn().ok();
    }

    #[task(binds = USART2, priority = 4, shared = [bus, reception])]
    fn serial(mut cx: serial::Context) {
        let (receiver, inbox) = cx.shared.reception;
        cx.shared.bus.lock(|bus| receiver.receive(bus, inbox));
        node::spawn().ok();
    }

    #[task(binds = CAN1_TX, priority = 4, shared = [bus])]
    fn can_sent(mut cx: can_sent::Context) {
        cx.shared.bus.lock(|bus| bus.on_sent());
        node::spawn().ok();
    }

    #[task(binds = CAN1_SCE, priority = 4, shared = [bus])]
    fn can_error(mut cx: can_error::Context) {
        cx.shared.bus.lock(|bus| bus.on_error());
        node::spawn().ok();
    }

    #[task(binds = SysTick, priority = 3, shared = [exchange, alive, control], local = [timer])]
    fn control(mut cx: control::Context) {
        let alive = cx.shared.alive.lock(core::mem::take);
        let (now, next) = cx.shared.control.tick(cx.shared.exchange, alive);
        cx.local.timer.schedule::<Selected>(now, next);
        node::spawn().ok();
    }

    #[task(priority = 3, shared = [exchange, control])]
    fn stop(cx: stop::Context) {
        cx.shared.control.stop(cx.shared.exchange);
        node::spawn().ok();
    }

    #[task(binds = TIM3, priority = 3, shared = [control])]
    fn refill(cx: refill::Context) {
        cx.shared.control.refill();
    }

    #[task(priority = 2, shared = [exchange, bus, alive, node])]
    fn node(mut cx: node::Context) {
        cx.shared.alive.lock(|alive| *alive = true);
        let (node, received) = cx.shared.node;
        let mut around = Around {
            exchange: &mut cx.shared.exchange,
            // An error says that one is on its way already.
            stop: || {
                stop::spawn().ok();
            },
        };
        // The next control tick is sooner than its deadline, or as soon, and runs it anyway.
        let _ = node.run(&mut around, &mut LockedBus(&mut cx.shared.bus), received);
        if let Some(signal) = node.signal(clock::now()) {
            lights::spawn(signal).ok();
        }
    }

    #[task(priority = 1, local = [panel])]
    fn lights(cx: lights::Context, signals: Signals) {
        cx.local.panel.advance(&signals);
    }
}
