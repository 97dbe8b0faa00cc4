//! A device with what other open stacks have by default, to measure its flash: four receive and four transmit PDOs, SYNC, TIME,
//! emergency messages, heartbeats both ways, LSS, and an SDO server without block transfer (`tests/eds/basic-device.eds`).
//!
//! This image is built and measured: frames and time come from cells that the compiler knows
//! nothing about, and what the device sends goes there too. There is no driver in it. The tests run
//! the same device ([`device`]) on a simulated bus.
#![no_std]
#![no_main]

use canopen::cia301::nmt::NmtState;
use canopen::{Event, Frame, Instant, NodeId};
use cortex_m_rt::entry;
// Only for the linker script of the firmware, which expects its symbols.
use defmt as _;
use stm32f4xx_hal as _;

mod device;
/// The object dictionary.
mod dictionary {
    include!(concat!(env!("OUT_DIR"), "/basic_device.rs"));
}

use device::BasicDevice;

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
    let node_id = NodeId::new(input() as u8).unwrap_or(NodeId::UNCONFIGURED);
    let mut device = BasicDevice::new(node_id, now());
    loop {
        device.receive(&frame(), now());
        output(device.poll(now()).ticks() as u32);
        while let Some(frame) = device.transmit() {
            output(frame.standard_id().unwrap_or(0).into());
            for byte in frame.payload() {
                output((*byte).into());
            }
        }
        while let Some(event) = device.event(now()) {
            match event {
                Event::StateChanged(state) => output((state == NmtState::Operational).into()),
                Event::StoreSettings(settings) => output(settings.node_id.get().into()),
                Event::SwitchBitRate { bit_rate, at } => {
                    output(bit_rate.table_index().into());
                    output(at.ticks() as u32);
                }
                _ => {}
            }
        }
        output(device.exchange(input()));
        match input() {
            0 => device.alarm(true, now()),
            1 => device.alarm(false, now()),
            2 => output(device.send_time_of_day(now()).into()),
            _ => output(
                device
                    .time_of_day(now())
                    .map_or(0, |time| time.milliseconds()),
            ),
        }
    }
}
