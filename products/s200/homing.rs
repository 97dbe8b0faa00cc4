//! What the S200 makes of a homing method when homing begins: for its time another method or offset takes the place of the master's.
//!
//! The manual has names alone but for -1. Chosen:
//! - Method -1 is 33 or 34, the nearer way to the zero of the turn that PRD shows.
//! - REFMODE 1 takes the edge of the switch and no zero pulse. REFLS 1 takes the limit switch in place of the reference switch.
//! - ENCZERO is added to the offset of methods with a zero pulse, ROFFSABS to that of methods that take the position as it is.
//! - VREF0 is by how much 6099h:2 is less than 6099h:1, which VREF is. AUTOHOME 1 begins homing where the motor is enabled and knows no reference.

use canopen::cia301::sdo::AbortCode;
use canopen::od::{Dictionary, Entry};
use cia402::behaviour::{Requests, number, put_number};

use super::Seen;

/// Methods with a zero pulse at a switch, and those without.
const WITHOUT_PULSE: [(i64, i64); 4] = [(1, 17), (2, 18), (8, 24), (12, 28)];
/// Methods with a reference switch, and those with the limit switch in its direction.
const AT_LIMIT: [(i64, i64); 4] = [(8, 2), (12, 1), (24, 18), (28, 17)];
/// Methods with a zero pulse, and those that take the position as it is.
const ZEROING: [i64; 7] = [-3, 1, 2, 8, 12, 33, 34];
const AS_IT_IS: [i64; 2] = [-2, 35];

/// What is to be put back.
#[derive(Debug, Default)]
pub(super) struct Reference {
    method: Option<i64>,
    offset: Option<i64>,
    ticks: u8,
}

pub(super) fn check(entry: &Entry, value: i64) -> Result<(), AbortCode> {
    let is_known = match (entry.index, entry.sub) {
        (0x363C | 0x365D | 0x36D7, 1) => (0..=1).contains(&value),
        (0x3698, 1) => (0..=1_000).contains(&value),
        _ => true,
    };
    is_known.then_some(()).ok_or(AbortCode::InvalidValue)
}

/// VREF0 counts where one of the speeds is written. Returns whether it did.
pub(super) fn written<D: Dictionary>(dictionary: &mut D, entry: &Entry) -> bool {
    let factor = number(dictionary, 0x3698, 1);
    let is_speed = matches!((entry.index, entry.sub), (0x6099 | 0x3628 | 0x3698, 1));
    if !is_speed || factor == 0 {
        return false;
    }
    let speed = number(dictionary, 0x6099, 1).checked_div(factor);
    put_number(dictionary, 0x6099, 2, speed.unwrap_or(0).max(1));
    true
}

/// The method of the table that stands for this one.
fn instead(table: &[(i64, i64)], method: i64) -> i64 {
    let own = table.iter().find(|(own, _)| *own == method);
    own.map_or(method, |(_, other)| *other)
}

impl Reference {
    /// Homing begins with the next commands.
    pub(super) fn begin<D: Dictionary>(
        &mut self,
        dictionary: &mut D,
        seen: &Seen,
        requests: &mut Requests,
    ) {
        if self.method.is_some() || self.offset.is_some() {
            return;
        }
        let own = number(dictionary, 0x6098, 0);
        let mut method = own;
        if method == -1 {
            method = if seen.internal & 0x8000 == 0 { 33 } else { 34 };
        }
        if number(dictionary, 0x365D, 1) == 1 {
            method = instead(&AT_LIMIT, method);
        }
        if number(dictionary, 0x363C, 1) == 1 {
            method = instead(&WITHOUT_PULSE, method);
        }
        self.ticks = 0;
        if method != own {
            self.method = Some(own);
            put_number(dictionary, 0x6098, 0, method);
            requests.configuration = true;
        }
        let shift = if ZEROING.contains(&method) {
            number(dictionary, 0x3537, 1)
        } else if AS_IT_IS.contains(&method) {
            number(dictionary, 0x3656, 1)
        } else {
            0
        };
        if shift != 0 {
            let offset = number(dictionary, 0x607C, 0);
            self.offset = Some(offset);
            requests.write = Some((0x607C, 0, offset.saturating_add(shift)));
        }
    }

    /// A tick has passed; `is_ordered` while a command has begun homing and is not done.
    pub(super) fn tick<D: Dictionary>(
        &mut self,
        dictionary: &mut D,
        seen: &Seen,
        is_ordered: bool,
        requests: &mut Requests,
    ) {
        if self.method.is_none() && self.offset.is_none() {
            return;
        }
        self.ticks = self.ticks.saturating_add(1);
        let has_ended = seen.statusword & 0x3400 != 0 || seen.mode != 6;
        if is_ordered && seen.is_enabled || self.ticks < 5 || !has_ended && seen.is_enabled {
            return;
        }
        if let Some(method) = self.method.take() {
            put_number(dictionary, 0x6098, 0, method);
            requests.configuration = true;
        }
        if let Some(offset) = self.offset.take() {
            requests.write = Some((0x607C, 0, offset));
        }
    }
}
