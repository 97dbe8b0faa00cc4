//! Proof that `canopen`, `motion`, `servo`, `cia402` and `runtime` cannot panic.
//!
//! This image drives everything they offer with inputs the compiler cannot know. Its panic handler calls a function
//! that does not exist: if one path to a panic is left after optimisation, the handler stays in the image and linking
//! fails with `undefined symbol: a_panic_path_is_linked`. It is built, never run.
#![no_std]
#![no_main]

use core::sync::atomic::AtomicU32;

use canopen::cia301::emergency::Emergency;
use canopen::cia301::nmt::Reset;
use canopen::cia301::sdo::{AbortCode, Completion};
use canopen::cia301::time_stamp::TimeOfDay;
use canopen::node::StoreError;
use canopen::od::{self, DayTime, StorageGroup, Value};
use canopen::{
    Application, BitRate, ControllerState, Duration, Frame, Instant, Node, NodeId, Outbox, Settings,
};
use cia402::binding::{self, Conversion, Number};
use cia402::cyclic::TickTimer;
use cia402::inputs::{self, Capture, Captured, DigitalInputs, Edges};
use cia402::recorder::{Memory, Recorder};
use cia402::{Device, Drive, DriveConfig, Exchange, Inputs, Share};
use cortex_m_rt::entry;
// Only for the linker script of the firmware, which expects its symbols.
use defmt as _;
use embedded_can::{ExtendedId, Frame as _, StandardId};
use motion::advanced_timer::{Output, Ring};
use motion::step_interrupt;
use motion::Axis;
use runtime::Machine;
use stm32f4xx_hal as _;

#[path = "no_panic/commissioning.rs"]
mod commissioning;
#[path = "no_panic/hosted.rs"]
mod hosted;
#[path = "no_panic/motion.rs"]
mod motion_crate;
#[path = "no_panic/moving.rs"]
mod moving;
#[path = "no_panic/outside.rs"]
mod outside;
#[path = "no_panic/servo.rs"]
mod servo;
#[path = "no_panic/stage.rs"]
mod stage;
#[path = "no_panic/units.rs"]
mod units;

use commissioning::{any_power_on, Commissioning};
use hosted::Hosted;
use motion_crate::{
    any_config, any_timing, axis, homing, plan, pulses, timer_pulses, AnyRegisters, Sink, Timer,
};
use moving::{Axis402, Moving};
use outside::{AnyMailboxes, AnyStore};

/// The object dictionary of the drive.
mod dictionary {
    include!(concat!(env!("OUT_DIR"), "/dictionary.rs"));
}

use dictionary::Dictionary;

/// The same objects in a device that was compiled with all that the crate can do, whatever its data sheet lists.
struct Everything(Dictionary);

impl od::Dictionary for Everything {
    const TABLE: &'static od::Table = <Dictionary as od::Dictionary>::TABLE;

    const FEATURES: od::Features = od::Features::ALL;

    type Counts = <Dictionary as od::Dictionary>::Counts;

    fn ram(&self) -> &[u8] {
        self.0.ram()
    }

    fn ram_mut(&mut self) -> &mut [u8] {
        self.0.ram_mut()
    }
}

unsafe extern "C" {
    fn a_panic_path_is_linked() -> !;
}

#[panic_handler]
fn panic(_: &core::panic::PanicInfo) -> ! {
    // SAFETY: there is no such function, so an image with this call in it never links.
    unsafe { a_panic_path_is_linked() }
}

/// Inputs and results go through these cells; the compiler must take every value for possible.
static mut CELL: [u32; 2] = [0; 2];

/// Any number.
#[inline(never)]
fn any() -> u32 {
    // SAFETY: one thread, no interrupts, and the cell lives for ever.
    unsafe { (&raw const CELL[0]).read_volatile() }
}

/// Looks at a result, so that the work for it is not left out.
#[inline(never)]
fn look(result: u32) {
    // SAFETY: as in `any`.
    unsafe { (&raw mut CELL[1]).write_volatile(result) }
}

fn any_u64() -> u64 {
    u64::from(any()) << 32 | u64::from(any())
}

fn any_bytes() -> [u8; 8] {
    any_u64().to_le_bytes()
}

fn any_frame() -> Frame {
    let bytes = any_bytes();
    let data = bytes.get(..any() as usize).unwrap_or(&bytes);
    match any() {
        0 => Frame::remote_frame(any() as u16, any() as u8),
        1 => ExtendedId::new(any())
            .and_then(|id| Frame::new(id, data))
            .unwrap_or(Frame::data_frame(0, data)),
        2 => StandardId::new(any() as u16)
            .and_then(|id| Frame::new_remote(id, any() as usize))
            .unwrap_or(Frame::data_frame(0, data)),
        _ => Frame::data_frame(any() as u16, data),
    }
}

fn any_settings() -> Settings {
    Settings {
        node_id: NodeId::new(any() as u8).unwrap_or(NodeId::UNCONFIGURED),
        bit_rate: any_bit_rate(),
    }
}

fn any_bit_rate() -> BitRate {
    BitRate::from_table_index(any() as u8).unwrap_or(BitRate::Kbit100)
}

fn any_time() -> Instant {
    Instant::from_ticks(any_u64())
}

fn any_result() -> Result<(), StoreError> {
    match any() {
        0 => Ok(()),
        1 => Err(StoreError::Medium),
        _ => Err(StoreError::NotSupported),
    }
}

/// An application that accepts and refuses at will.
struct Objects;

impl<D: od::Dictionary> Application<D> for Objects {
    fn validate(&mut self, _: &D, entry: &od::Entry, value: &[u8]) -> Result<(), AbortCode> {
        look(entry.key() + value.len() as u32);
        any_refusal(())
    }

    fn size(&mut self, _: &D, _: &od::Entry) -> Result<Option<u32>, AbortCode> {
        any_refusal((any() == 0).then_some(any()))
    }

    fn read_at(
        &mut self,
        _: &D,
        _: &od::Entry,
        position: u32,
        into: &mut [u8],
    ) -> Result<usize, AbortCode> {
        look(position + into.len() as u32);
        any_refusal(any() as usize)
    }

    fn begin_write(&mut self, _: &D, _: &od::Entry, size: Option<u32>) -> Result<(), AbortCode> {
        look(size.unwrap_or(0));
        any_refusal(())
    }

    fn write_at(
        &mut self,
        _: &D,
        _: &od::Entry,
        position: u32,
        data: &[u8],
    ) -> Result<(), AbortCode> {
        look(position + data.len() as u32);
        any_refusal(())
    }

    fn end_write(
        &mut self,
        _: &mut D,
        _: &od::Entry,
        length: u32,
    ) -> Result<Completion, AbortCode> {
        look(length);
        any_refusal(if any() == 0 {
            Completion::Now
        } else {
            Completion::Later
        })
    }
}

/// This, or a refusal.
fn any_refusal<T>(value: T) -> Result<T, AbortCode> {
    if any() == 0 {
        Ok(value)
    } else {
        Err(AbortCode::General)
    }
}

#[inline(never)]
fn node(node: &mut Node<Everything>) {
    match any() {
        0 => node.boot(
            if any() == 0 {
                Reset::Node
            } else {
                Reset::Communication
            },
            any_time(),
            &mut Objects,
        ),
        1 => node.report(
            Emergency {
                code: any() as u16,
                register: any() as u8,
                info: any_bytes().first_chunk().copied().unwrap_or_default(),
            },
            any_time(),
        ),
        2 => node.clear(any() as u16, any_time()),
        3 => node.settings_stored(any_result()),
        13 => node.bit_rate_found(any_bit_rate(), any_time()),
        4 => look(node.poll(any_time(), &mut Objects).ticks() as u32),
        5 => {
            if let Some(frame) = node.transmit(&mut Objects) {
                look(u32::from(frame.length()) + u32::from(frame.standard_id().unwrap_or(0)));
            }
        }
        6 => look(node.event().is_some().into()),
        10 => network(node),
        7 => {
            look(node.overflows() + u32::from(node.settings().node_id.get()) + node.state() as u32);
        }
        12 => look(
            node.announce(any() as u16, any() as u8, any_time())
                .is_ok()
                .into(),
        ),
        9 => {
            let value = any().to_le_bytes();
            let sent = node.send_to(any() as u8, any() as u16, any() as u8, value, any_time());
            look(sent.is_ok().into());
        }
        11 => node.complete_write(any() as u16, any() as u8, any_refusal(())),
        _ => node.receive(&any_frame(), any_time(), &mut Objects),
    }
}

/// What the node knows of the network and of its controller.
#[inline(never)]
fn network(node: &mut Node<Everything>) {
    match any() {
        0 => node.controller_changed(any_controller_state(), any_time()),
        1 => node.frames_lost(any(), any_time()),
        2 => node.set_restart_delay((any() == 0).then_some(Duration::from_ticks(any_u64()))),
        3 => {
            let counters = node.counters();
            look(counters.bus_off + counters.restarts + counters.error_passive);
            look(counters.lost_frames + counters.overflows);
        }
        4 => look(node.take_network_loss().into()),
        5 => {
            let state = NodeId::new(any() as u8).and_then(|node_id| node.remote_state(node_id));
            look(state.map_or(0, |state| state as u32));
        }
        6 => {
            if let Some(time) = TimeOfDay::new(any() as u16, any()) {
                node.set_time_of_day(time, any_time());
            }
        }
        7 => look(
            node.time_of_day(any_time())
                .map_or(0, |time| time.milliseconds() + u32::from(time.days())),
        ),
        8 => look(node.send_time_of_day(any_time()).into()),
        9 => node.load_parameters(&mut AnyStore, any_time(), &mut Objects),
        10 => node.store_parameters(&mut AnyStore, any_time()),
        11 => node.refuse_storing(AbortCode::DeviceState),
        _ => look(u32::from(node.is_loading()) + u32::from(node.is_storing())),
    }
}

fn any_controller_state() -> ControllerState {
    match any() {
        0 => ControllerState::ErrorActive,
        1 => ControllerState::Warning,
        2 => ControllerState::ErrorPassive,
        _ => ControllerState::BusOff,
    }
}

/// The memory of the scope.
static SCOPE: Memory<[AtomicU32; 64]> = Memory::new();

/// Edges of an input.
fn any_edges() -> Edges {
    let edge = || inputs::Edge {
        position: any() as i32,
        time: any(),
    };
    let mut edges = Edges::one(edge());
    edges.count = any() as u16;
    edges.add(edge());
    edges
}

/// What an input interrupt and a control tick do with edges.
fn capture(edges: &Capture) {
    let mut inputs = DigitalInputs::NONE;
    edges.begin(any() as u8);
    edges.note(any() as u8, any() as u8, |_| any(), any());
    edges.take(any() as u8, &mut inputs, |_| any(), |_| any() as i32);
    look(u32::from(inputs.levels) | u32::from(inputs.changed));
    look(inputs::time_of_edge(any_time(), any(), any()));
}

/// What a board may measure.
fn any_inputs() -> Inputs {
    Inputs {
        supply: any() == 0,
        position: any_u64() as i64,
        warning: (any() == 0).then_some(any() as u16),
        fault: (any() == 0).then_some(any() as u16),
        digital: DigitalInputs {
            levels: any() as u8,
            changed: any() as u8,
            captured: [(); inputs::COUNT].map(|()| Captured {
                rose: (any() == 0).then(any_edges),
                fell: (any() == 0).then(any_edges),
            }),
        },
        stall: (any() == 0).then(|| any() == 0),
        absolute_turn: any(),
        position_tolerance: any(),
        supply_voltage: (any() == 0).then(any),
        temperature: (any() == 0).then(|| any() as i16),
        analogue: (any() == 0).then(|| any() as u16),
        auxiliary_voltage: (any() == 0).then(any),
        battery_voltage: (any() == 0).then(any),
        has_compare: any() == 0,
        counter: any() as i32,
    }
}

#[inline(never)]
fn drive(
    device: &mut Device<Dictionary, Machine<[u8; 64], &'static Memory>>,
    (drive, recorder): (
        &mut Drive<Dictionary, Axis402>,
        &mut Recorder<&'static Memory>,
    ),
    exchange: &mut impl Share,
    outbox: &mut Outbox<3>,
) {
    match any() {
        0 => device.power_on(any_time(), exchange),
        1 => look(device.poll(any_time(), exchange).ticks() as u32),
        2 => device.settings_stored(any_result()),
        15 => device.bit_rate_found(any_bit_rate(), any_time()),
        3 => look(device.event().is_some().into()),
        4 => {
            if let Some(frame) = device.transmit() {
                look(u32::from(frame.length()) + u32::from(frame.standard_id().unwrap_or(0)));
            }
        }
        5 => {
            let inputs = any_inputs();
            let outputs = if any() == 0 {
                drive.early_tick(any_time(), &inputs, &mut Sink, exchange)
            } else {
                drive.tick(any_time(), &inputs, &mut Sink, exchange)
            };
            drive.refill(&mut Sink);
            look(u32::from(outputs.power_stage) + u32::from(outputs.drop_pulses));
            look(u32::from(outputs.current) + u32::from(outputs.digital));
        }
        6 => look(exchange.lock(|exchange| exchange.is_safe()).into()),
        16 => recorder.tick(drive, exchange),
        7 => device.controller_changed(any_controller_state(), any_time(), exchange),
        8 => device.frames_lost(any(), any_time()),
        9 => device.set_restart_delay((any() == 0).then_some(Duration::from_ticks(any_u64()))),
        10 => device.serve_store(&mut AnyStore, any_time(), exchange),
        11 => outbox.send(device, &mut AnyMailboxes),
        12 => outbox.clear(),
        14 => device.drop_late(any_time()),
        13 => look(device.application().user_memory().len() as u32),
        17 => look(device.calls_early().into()),
        18 => look(exchange.lock(|exchange| exchange.calls_early()).into()),
        _ => device.receive(&any_frame(), any_time(), exchange),
    }
}

/// The getters and setters of dictionaries, and what bindings calculate.
fn values() {
    let bytes = any_bytes();
    let all = bytes.get(..any() as usize).unwrap_or(&bytes);
    look(i32::of(all) as u32 ^ u64::of(all) as u32 ^ u32::from(bool::of(all)));
    look(DayTime::of(all).milliseconds ^ f64::of(all).to_bits() as u32);
    look(od::signed_bytes::<5>(any_u64() as i64).is_ok() as u32);
    look(od::unsigned_bytes::<7>(any_u64()).is_ok() as u32);
    // As the generated dictionaries have it: what is wrong with it is found when they are built.
    let conversion = const { Conversion::new(8, -5, 7) };
    let number = conversion.to_parameter(any_u64() as i64);
    look(u32::nearest(number) ^ i8::nearest(conversion.to_object(number)) as u32);
    look(binding::within(Some(number), -5, 7).is_ok() as u32);
    for group in [
        StorageGroup::Communication,
        StorageGroup::Application,
        StorageGroup::Manufacturer,
    ] {
        look(<Dictionary as od::Dictionary>::TABLE.stored(group).len() as u32);
    }
}

#[entry]
fn main() -> ! {
    let mut exchange = Exchange::new();
    let machine = Machine::new([0; 64], [0; 64], &SCOPE as &'static Memory);
    let mut device = Device::with_application(Dictionary::new(), any_settings(), any(), machine);
    device.store_parameters_here();
    device.detect();
    device.start(&any_power_on());
    device.produced_as((any() == 0).then(any));
    let mut outbox = Outbox::new();
    let mut plain = Node::new(Everything(Dictionary::new()), any_settings()).with_parameter_store();
    plain.detect();
    plain.start(&any_power_on());
    let mut commissioning = Commissioning::new();
    let mut shared = step_interrupt::Shared::new();
    let (mut queue, mut player) = step_interrupt::split(&mut shared, Timer, any_timing());
    let ring = Ring::new();
    let edges = Capture::new();
    let mut output = Output::new(AnyRegisters, &ring);
    loop {
        timer_pulses(&mut output);
        let Some(config) = any_config() else { continue };
        let mut stepper = Axis::new(config);
        let mut search = None;
        let mut timer = TickTimer::new(Duration::from_ticks(any_u64()));
        let drive_config = DriveConfig {
            axis: config,
            tick: Duration::from_ticks(any_u64()),
            refills: any(),
        };
        let mut hosted = Hosted::new(drive_config);
        let mut driver = Axis402::drive(drive_config);
        let mut recorder =
            Recorder::new(&SCOPE as &'static Memory, Duration::from_ticks(any_u64()));
        while any() != 0 {
            node(&mut plain);
            hosted.run();
            commissioning.advance(&plain);
            let halves = (&mut driver, &mut recorder);
            drive(&mut device, halves, &mut exchange, &mut outbox);
            axis(&mut stepper);
            homing(&mut search);
            plan(config.clock);
            values();
            units::units();
            look(servo::servo().is_ok().into());
            look(stage::loops(drive_config).is_ok().into());
            capture(&edges);
            pulses(&mut queue, &mut player);
            let due = (any() == 0).then(any_time);
            look(timer.next(any_time(), due).unwrap_or(0));
        }
    }
}
