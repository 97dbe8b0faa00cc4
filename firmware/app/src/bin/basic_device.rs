//! A device with what other open stacks have by default, to measure its flash: four receive and four transmit PDOs, SYNC, TIME,
//! emergency messages, heartbeats both ways, LSS, and an SDO server without block transfer (`tests/eds/basic-device.eds`).
//!
//! It is built and measured, never run: frames and time come from cells that the compiler knows nothing about, and what the
//! device sends goes there too. There is no driver in it.
#![no_std]
#![no_main]

use canopen::cia301::emergency::{Emergency, ErrorRegister};
use canopen::cia301::nmt::{NmtState, Reset};
use canopen::{BitRate, Event, Frame, Instant, Node, NodeId, Settings};
use cortex_m_rt::entry;
// Only for the linker script of the firmware, which expects its symbols.
use defmt as _;
use stm32f4xx_hal as _;

/// The object dictionary.
mod dictionary {
    include!(concat!(env!("OUT_DIR"), "/basic_device.rs"));
}

use dictionary::Dictionary;

#[panic_handler]
fn panic(_: &core::panic::PanicInfo) -> ! {
    loop {}
}

/// What stands for the hardware.
static mut CELL: [u32; 2] = [0; 2];

/// A number from the hardware.
#[inline(never)]
fn input() -> u32 {
    // SAFETY: one thread, no interrupts, and the cell lives for ever.
    unsafe { (&raw const CELL[0]).read_volatile() }
}

/// A number for the hardware.
#[inline(never)]
fn output(number: u32) {
    // SAFETY: as in `input`.
    unsafe { (&raw mut CELL[1]).write_volatile(number) }
}

fn now() -> Instant {
    Instant::from_ticks(u64::from(input()) << 32 | u64::from(input()))
}

fn frame() -> Frame {
    let data = (u64::from(input()) << 32 | u64::from(input())).to_le_bytes();
    match input() {
        0 => Frame::remote_frame(input() as u16, 8),
        length => Frame::data_frame(input() as u16, data.get(..length as usize).unwrap_or(&data)),
    }
}

#[entry]
fn main() -> ! {
    let settings = Settings {
        node_id: NodeId::new(input() as u8).unwrap_or(NodeId::UNCONFIGURED),
        bit_rate: BitRate::Kbit1000,
    };
    let mut node = Node::new(Dictionary::new(), settings);
    node.boot(Reset::Node, now(), &mut ());
    loop {
        node.receive(&frame(), now(), &mut ());
        output(node.poll(now(), &mut ()).ticks() as u32);
        while let Some(frame) = node.transmit(&mut ()) {
            output(frame.standard_id().unwrap_or(0).into());
            for byte in frame.payload() {
                output((*byte).into());
            }
        }
        while let Some(event) = node.event() {
            match event {
                Event::StateChanged(state) => output((state == NmtState::Operational).into()),
                Event::ResetRequested(reset) => node.boot(reset, now(), &mut ()),
                Event::StoreSettings(settings) => {
                    output(settings.node_id.get().into());
                    node.settings_stored(Ok(()));
                }
                Event::SwitchBitRate { bit_rate, at } => {
                    output(bit_rate.table_index().into());
                    output(at.ticks() as u32);
                }
                _ => {}
            }
        }
        // The application: values in and out, an error that comes and goes, the time of day.
        let dictionary = node.dictionary_mut();
        dictionary.set_sent_number_1(input());
        output(dictionary.received_number_1());
        let error = Emergency {
            code: 0x2310,
            register: ErrorRegister::CURRENT,
            info: [0; 5],
        };
        match input() {
            0 => node.report(error, now()),
            1 => node.clear(error.code, now()),
            2 => output(node.send_time_of_day(now()).into()),
            _ => output(
                node.time_of_day(now())
                    .map_or(0, |time| time.milliseconds()),
            ),
        }
    }
}
