//! Bit timing of the CAN controller, from its clock of 42 MHz ([`canopen::bit_timing`]).
//!
//! 800 kbit/s cannot be made: it would take 52.5 clocks a bit.

use canopen::bit_timing::{reachable, Limits, Timing};
use canopen::cia305::DETECTABLE;
use canopen::BitRate;

const CLOCK_HZ: u32 = 42_000_000;

/// What can be made: all of CiA 301 but 800 kbit/s, and 100 kbit/s.
const REACHABLE: ([BitRate; DETECTABLE.len()], usize) =
    reachable(CLOCK_HZ, &Limits::BXCAN, DETECTABLE);

/// The bit rates that can be made.
pub const BIT_RATES: [BitRate; REACHABLE.1] = {
    let mut bit_rates = [BitRate::Kbit1000; REACHABLE.1];
    let mut i = 0;
    while i < bit_rates.len() {
        bit_rates[i] = REACHABLE.0[i];
        i += 1;
    }
    bit_rates
};

/// The value of the bit timing register CAN_BTR (RM0090, 32.9.2); `None` for a bit rate that cannot be made.
pub fn register(bit_rate: BitRate) -> Option<u32> {
    Timing::new(CLOCK_HZ, bit_rate, &Limits::BXCAN).map(|timing| timing.bxcan_register())
}
