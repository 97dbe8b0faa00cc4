//! Automatic bit rate detection: a device that does not know the bit rate of its network finds it by listening.
//!
//! It tries one bit rate after the other with a controller that is silent: such a controller sends nothing, neither frames nor
//! acknowledges nor error flags, so the others never notice. A frame that arrives whole shows the right bit rate, as the checksum of
//! a frame read at a wrong one does not fit. A frame that arrives broken shows a wrong one.
//!
//! The contract:
//! - Bit rates are tried in the order 1000, 500, 250, 125, 800, 100, 50, 20, 10 kbit/s, those left out that the controller cannot
//!   make, and from the beginning again, until one is found. On a network where nobody speaks this has no end.
//! - A broken frame ends a try at once, so on a busy network every bit rate costs a frame. Silence ends it after
//!   [`PATIENCE`], which is longer than a second: a heartbeat a second is enough to be found.
//! - Nothing is sent before a bit rate is found. The frame that shows it is not acknowledged and not served.
//!
//! - A controller leaves a bit rate no sooner than the frame ends that is on the bus. What it receives until then speaks for the old
//!   bit rate: a whole frame shows that it was right, such as the second attempt at one that was disturbed; an error says nothing new.
//!
//! The search is a value, as always: the firmware sets its controller to [`Detection::bit_rate`] in silent mode and tells what it
//! sees. When [`Detection::is_over`] it takes the controller off the bus, tells of the frames that came before, and then, with
//! [`Detection::left`], that it is done.

use crate::settings::BitRate;
use crate::time::{Duration, Instant};

/// The bit rates that can be found, in the order in which they are tried.
pub const DETECTABLE: [BitRate; 9] = [
    BitRate::Kbit1000,
    BitRate::Kbit500,
    BitRate::Kbit250,
    BitRate::Kbit125,
    BitRate::Kbit800,
    BitRate::Kbit100,
    BitRate::Kbit50,
    BitRate::Kbit20,
    BitRate::Kbit10,
];

/// How long a silent network is listened to at one bit rate.
pub const PATIENCE: Duration = Duration::millis(1_200);

/// A search for the bit rate.
#[derive(Clone, Debug)]
pub struct Detection {
    /// The bit rates that the controller makes, a bit for each place in [`DETECTABLE`].
    supported: u16,
    /// The place of the one that is tried.
    place: usize,
    until: Instant,
    /// The controller is to leave this bit rate.
    over: bool,
    found: bool,
}

impl Detection {
    /// A search that begins now, with the first of [`DETECTABLE`] that is among `supported`. If none is, every one is tried.
    pub fn new(supported: &[BitRate], now: Instant) -> Self {
        let mask = DETECTABLE.iter().rev().fold(0, |mask, rate| {
            mask << 1 | u16::from(supported.contains(rate))
        });
        let mut detection = Self {
            supported: if mask == 0 { u16::MAX } else { mask },
            place: DETECTABLE.len(),
            until: now,
            over: false,
            found: false,
        };
        detection.go_on(now);
        detection
    }

    /// What the controller is to listen at, silent. It is the bit rate of the network once [`Detection::found`] has it.
    pub fn bit_rate(&self) -> BitRate {
        let rate = DETECTABLE.get(self.place).copied();
        rate.unwrap_or(BitRate::Kbit1000)
    }

    /// The bit rate of the network, once it is known.
    pub fn found(&self) -> Option<BitRate> {
        self.found.then(|| self.bit_rate())
    }

    /// Whether the controller is to leave [`Detection::bit_rate`], as the try has ended or the search has.
    pub const fn is_over(&self) -> bool {
        self.over || self.found
    }

    /// The controller has left [`Detection::bit_rate`], and all frames it had received there were told: unless one has shown that
    /// this is the one, the next is tried from now on.
    pub fn left(&mut self, now: Instant) {
        if !self.found {
            self.go_on(now);
        }
    }

    /// A whole frame arrived at [`Detection::bit_rate`].
    pub fn frame_received(&mut self) {
        self.found = true;
    }

    /// A broken frame was seen at [`Detection::bit_rate`]: it is the wrong one.
    pub const fn error_seen(&mut self) {
        self.over = true;
    }

    /// Lets time pass. Returns when it wants to be called again; look at [`Detection::is_over`] after each call.
    pub fn poll(&mut self, now: Instant) -> Instant {
        self.over |= now >= self.until;
        if self.is_over() {
            return crate::time::NEVER;
        }
        self.until
    }

    /// Tries the next bit rate.
    fn go_on(&mut self, now: Instant) {
        self.over = false;
        self.until = now.checked_add_duration(PATIENCE).unwrap_or(now);
        // Once round: at least one is supported.
        for _ in DETECTABLE {
            self.place = self.place.saturating_add(1);
            if self.place >= DETECTABLE.len() {
                self.place = 0;
            }
            if self.supported.checked_shr(self.place as u32).unwrap_or(0) & 1 != 0 {
                return;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::vec::Vec;

    use super::*;

    const START: Instant = Instant::from_ticks(7_000_000);

    fn after(milliseconds: u64) -> Instant {
        START + Duration::from_ticks(milliseconds * 1_000)
    }

    /// A broken frame, and the controller leaves at once.
    fn end_try(detection: &mut Detection, now: Instant) {
        detection.error_seen();
        detection.left(now);
    }

    #[test]
    fn every_bit_rate_is_tried_in_order_and_from_the_beginning_again() {
        let mut detection = Detection::new(&DETECTABLE, START);
        let mut tried = Vec::new();
        for round in 0..18 {
            tried.push(detection.bit_rate().kbit_per_second());
            let until = detection.poll(after(round * 1_200));
            assert_eq!(until, after((round + 1) * 1_200));
            assert!(!detection.is_over());
            detection.poll(until);
            assert!(detection.is_over());
            detection.left(until);
        }
        let order = [1000, 500, 250, 125, 800, 100, 50, 20, 10];
        assert_eq!(tried, order.repeat(2));
        assert_eq!(detection.found(), None);
    }

    #[test]
    fn bit_rates_that_the_controller_cannot_make_are_left_out() {
        let mut detection = Detection::new(&[BitRate::Kbit20, BitRate::Kbit125], START);
        for expected in [125, 20, 125, 20] {
            assert_eq!(detection.bit_rate().kbit_per_second(), expected);
            end_try(&mut detection, START);
        }
    }

    #[test]
    fn a_broken_frame_ends_a_try_at_once_and_the_next_has_its_full_time() {
        let mut detection = Detection::new(&DETECTABLE, START);
        end_try(&mut detection, after(1_000));
        assert_eq!(detection.bit_rate(), BitRate::Kbit500);
        assert_eq!(detection.poll(after(1_000)), after(2_200));
    }

    #[test]
    fn a_whole_frame_ends_the_search() {
        let mut detection = Detection::new(&DETECTABLE, START);
        end_try(&mut detection, START);
        detection.frame_received();
        assert!(detection.is_over());
        assert_eq!(detection.found(), Some(BitRate::Kbit500));
        end_try(&mut detection, after(1));
        assert_eq!(detection.poll(after(60_000)), crate::time::NEVER);
        assert_eq!(detection.found(), Some(BitRate::Kbit500));
    }

    #[test]
    fn a_whole_frame_while_the_controller_leaves_shows_the_bit_rate_that_it_leaves() {
        for is_silent in [false, true] {
            let mut detection = Detection::new(&DETECTABLE, START);
            if is_silent {
                detection.poll(after(1_200));
            } else {
                detection.error_seen();
            }
            assert!(detection.is_over());
            // The second attempt at the frame, before the controller is off the bus.
            detection.frame_received();
            detection.left(after(1_201));
            assert_eq!(detection.found(), Some(BitRate::Kbit1000));
        }
    }

    #[test]
    fn errors_while_the_controller_leaves_pass_over_no_bit_rate() {
        let mut detection = Detection::new(&DETECTABLE, START);
        for _ in 0..3 {
            detection.error_seen();
            detection.poll(after(5_000));
            assert_eq!(detection.bit_rate(), BitRate::Kbit1000);
        }
        detection.left(after(5_000));
        assert_eq!(detection.bit_rate(), BitRate::Kbit500);
        // Its time begins when the controller listens.
        assert_eq!(detection.poll(after(5_000)), after(6_200));
        assert!(!detection.is_over());
    }

    #[test]
    fn a_controller_of_which_nothing_is_known_tries_every_bit_rate() {
        let mut detection = Detection::new(&[], START);
        for rate in DETECTABLE {
            assert_eq!(detection.bit_rate(), rate);
            end_try(&mut detection, START);
        }
    }

    #[test]
    fn at_the_end_of_time_nothing_goes_wrong() {
        let mut detection = Detection::new(&DETECTABLE, crate::time::NEVER);
        detection.poll(crate::time::NEVER);
        end_try(&mut detection, crate::time::NEVER);
    }
}
