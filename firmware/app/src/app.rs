//! The RTIC app of a board. RTIC binds interrupts by their names in one device, so each board makes the app of itself; the tasks are the
//! same on all of them, and an image has the handlers of its own board only.

/// Makes the app of a board. `device` is its peripheral access crate, or a module like one; `dispatchers` are three interrupts that nothing uses, for the software
/// tasks. Behind each kind of task stand those of the board, each with its interrupt: none, one or several.
macro_rules! app {
    (
        device: $($device:ident)::+,
        dispatchers: [$($dispatcher:ident),+],
        pulses: [$($pulses:ident: $pulses_interrupt:ident),*],
        edge: [$($edge:ident: $edge_interrupt:ident),*],
        trip: [$($trip:ident: $trip_interrupt:ident),*],
        current: [$($current:ident: $current_interrupt:ident),*],
        loops: [$($loops:ident: $loops_interrupt:ident),*],
        can: [$($can:ident: $can_interrupt:ident),*],
        refill: [$($refill:ident: $refill_interrupt:ident),*],
        wake: [$($wake:ident: $wake_interrupt:ident),*],
    ) => {
        #[rtic::app(device = $($device)::+, peripherals = true, dispatchers = [$($dispatcher),+])]
        mod app {
            use core::mem::MaybeUninit;

            use cia402::inputs::Capture;
            use cia402::{Emitter, Exchange};
            use runtime::{inbox, Lost, Signals};

            use crate::board::{Board, ControlTimer, Selected};
            use crate::control::Control;
            use crate::stepping::Stepping;
            use crate::tasks::{self, CanBus, Firmware, Memory, NodeTask, Panel, Reception, Step};

            #[shared]
            struct Shared {
                exchange: &'static mut Exchange,
                bus: CanBus,
                alive: bool,
                #[lock_free]
                reception: Reception,
                stepping: &'static Stepping,
                #[lock_free]
                control: &'static mut Control,
                #[lock_free]
                node: &'static mut NodeTask,
                #[lock_free]
                step: Step,
            }

            #[local]
            struct Local {
                timer: ControlTimer,
                panel: Panel,
            }

            #[init(local = [
                frames: inbox::Memory = inbox::Memory::new(),
                lost: Lost = Lost::new(),
                edges: Capture = Capture::new(),
                // They begin where they stay: on the stack they would be more than all else that is ever there.
                exchange: MaybeUninit<Exchange> = MaybeUninit::uninit(),
                emitter: MaybeUninit<Emitter> = MaybeUninit::uninit(),
                stepping: MaybeUninit<Stepping> = MaybeUninit::uninit(),
                control: MaybeUninit<Control> = MaybeUninit::uninit(),
                node: MaybeUninit<NodeTask> = MaybeUninit::uninit(),
            ])]
            fn init(cx: init::Context) -> (Shared, Local, init::Monotonics) {
                let memory = Memory {
                    frames: cx.local.frames,
                    lost: cx.local.lost,
                    edges: cx.local.edges,
                    exchange: cx.local.exchange,
                    emitter: cx.local.emitter,
                    stepping: cx.local.stepping,
                    control: cx.local.control,
                    node: cx.local.node,
                };
                let Firmware {
                    exchange,
                    bus,
                    reception,
                    stepping,
                    control,
                    node,
                    step,
                    timer,
                    panel,
                } = tasks::start(cx.device, cx.core.SYST, memory);
                // It powers the node on, as soon as interrupts are on.
                node::spawn().ok();
                let shared = Shared {
                    exchange,
                    bus,
                    alive: true,
                    reception,
                    stepping,
                    control,
                    node,
                    step,
                };
                (shared, Local { timer, panel }, init::Monotonics())
            }

            #[idle]
            fn idle(_: idle::Context) -> ! {
                loop {
                    Selected::idle();
                }
            }

            $(
                #[task(binds = $trip_interrupt, priority = 8)]
                fn $trip(_: $trip::Context) {
                    Selected::trip();
                }
            )*

            $(
                #[task(binds = $current_interrupt, priority = 7)]
                fn $current(_: $current::Context) {
                    Selected::on_current();
                }
            )*

            $(
                #[task(binds = $loops_interrupt, priority = 6)]
                fn $loops(_: $loops::Context) {
                    Selected::on_loops();
                }
            )*

            $(
                #[task(binds = $pulses_interrupt, priority = 6, shared = [step])]
                fn $pulses(cx: $pulses::Context) {
                    cx.shared.step.on_interrupt();
                }
            )*

            $(
                #[task(binds = $edge_interrupt, priority = 6, shared = [step])]
                fn $edge(cx: $edge::Context) {
                    cx.shared.step.on_edge();
                }
            )*

            $(
                #[task(binds = $can_interrupt, priority = 5, shared = [bus, reception])]
                fn $can(mut cx: $can::Context) {
                    let reception = cx.shared.reception;
                    if cx.shared.bus.lock(|bus| reception.on_interrupt(bus)) {
                        // A command may have been among what was lost.
                        stop::spawn().ok();
                    }
                    // An error says that the task is on its way already.
                    node::spawn().ok();
                }
            )*

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

            $(
                #[task(binds = $refill_interrupt, priority = 4, shared = [&stepping])]
                fn $refill(cx: $refill::Context) {
                    cx.shared.stepping.refill();
                    // A motor that must not have current any more does not wait for the control tick.
                    if Selected::must_stop() || cx.shared.stepping.has_failed() {
                        stop::spawn().ok();
                    }
                    Selected::refill_done();
                }
            )*

            #[task(priority = 2, shared = [exchange, bus, alive, node])]
            fn node(mut cx: node::Context) {
                // The control tick takes it.
                let has_ticked = !cx.shared.alive.lock(|alive| core::mem::replace(alive, true));
                let stop = || {
                    stop::spawn().ok();
                };
                let node = cx.shared.node;
                let signals = node.run(cx.shared.exchange, cx.shared.bus, has_ticked, stop);
                if let Some(signals) = signals {
                    lights::spawn(signals).ok();
                }
            }

            $(
                #[task(binds = $wake_interrupt, priority = 2)]
                fn $wake(_: $wake::Context) {
                    Selected::woken();
                    node::spawn().ok();
                }
            )*

            #[task(priority = 1, local = [panel])]
            fn lights(cx: lights::Context, signals: Signals) {
                cx.local.panel.advance(&signals);
            }
        }
    };
}
