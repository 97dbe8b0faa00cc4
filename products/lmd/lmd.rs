//! What the LMD does that is no data: the inhibit input, filters of inputs, capture or trip, the targets of its set-points, reactions to a following
//! error, the temperature of its board.
//!
//! What its manual leaves open: "override" is a command that counts while the inhibit input is active, "overwrite" one that takes the place of the
//! controlword; a trip is a pulse of one control tick at output 3, when the demand passes the point in either direction.

mod inhibit;
mod trip;

use canopen::Instant;
use canopen::cia301::sdo::AbortCode;
use canopen::od::{Dictionary, Entry};
use cia402::behaviour::{Asks, Behaviour, View, number, put_number};
use cia402::commands::Commands;
use cia402::controlword::{CHANGE_IMMEDIATELY, NEW_SET_POINT, RELATIVE};
use cia402::units::Units;
use cia402::{Objects, State};

use inhibit::Inhibit;
use trip::Trip;

/// Objects of our own, which parameters of the drive are read from or shown in.
const DEBOUNCE: u16 = 0x5F00;
const RELEASE_TIME: u16 = 0x5F01;
const CAPTURES: u16 = 0x5F02;
const FILTERED: u16 = 0x5F03;
const RAW: u16 = 0x5F04;

/// 2031h: the trip output takes the place of the capture input.
const HAS_TRIP: i64 = 1 << 2;

/// Outputs are off at this temperature, whatever the thresholds are.
const HOTTEST: i64 = 85;

/// Causes of our own in the table of errors: the board is warm, it is hot, the motor is not where it should be.
const WARM: u16 = 0x4311;
const HOT: u16 = 0x4212;
const FOLLOWING_ERROR: u16 = 0x8613;

/// So many control ticks behind a set-point the statusword tells of it.
const SETTLED: u8 = 3;

/// 6041h.
const ACKNOWLEDGE: u16 = 1 << 12;
const IS_BEHIND: u16 = 1 << 13;

/// The module.
#[derive(Debug, Default)]
pub struct Module {
    inhibit: Inhibit,
    trip: Trip,
    asks: Asks,
    statusword: u16,
    position: i32,
    is_enabled: bool,
    is_moving: bool,
    /// 60FDh, as the wires are.
    wires: u32,
    /// A set-point waits for the one under way.
    waits: bool,
    /// Control ticks since a set-point was handed over: the statusword tells of it a few later.
    since: u8,
    ticked: Option<Instant>,
    captures: i64,
    is_warm: bool,
    is_hot: bool,
    is_behind: bool,
    /// The bridge is off until the controlword is written anew.
    is_disabled: bool,
    fault: Option<u16>,
}

impl Module {
    /// 2211h and 2212h: an edge of bit 4 hands over a set-point.
    fn take_set_point<D: Dictionary + Objects>(&mut self, dictionary: &mut D, word: u16) {
        let target = i64::from(dictionary.target_position());
        let target = if word & RELATIVE != 0 {
            number(dictionary, 0x2212, 0).saturating_add(target)
        } else {
            target
        };
        let is_under_way = self.since < SETTLED || self.is_moving;
        self.waits = word & CHANGE_IMMEDIATELY == 0 && is_under_way;
        self.since = 0;
        put_number(dictionary, 0x2212, 0, target);
        if !self.waits {
            put_number(dictionary, 0x2211, 0, target);
        }
    }

    /// What hangs on the set-up: one filter for the home switch and the limits, the longest of theirs; the delays before motion add up.
    fn set_up<D: Dictionary>(&mut self, dictionary: &mut D) {
        let switches = (1..=3).fold(0, |all, sub| all | number(dictionary, 0x2002, sub));
        let time = inhibit::filter(dictionary, switches);
        put_number(dictionary, DEBOUNCE, 0, time);
        let release = number(dictionary, 0x2034, 1) + number(dictionary, 0x2035, 2);
        put_number(dictionary, RELEASE_TIME, 0, release.min(0xFFFF));
        self.asks.configuration = true;
    }

    /// The reading of the analogue input, filtered if it is to be.
    fn show_analogue<D: Dictionary>(dictionary: &mut D) {
        let full = if number(dictionary, 0x2010, 2) == 8 {
            10_000
        } else {
            5_000
        };
        let reading = match number(dictionary, 0x2010, 3) {
            0 => number(dictionary, RAW, 0),
            _ => number(dictionary, FILTERED, 0) * 4_095 / full,
        };
        put_number(dictionary, 0x2010, 1, reading.clamp(0, 4_095));
    }

    /// The sensor of the bridge stands for that of the board too: 2018h.
    fn look_at_temperature<D: Dictionary>(&mut self, dictionary: &mut D) {
        let temperature = number(dictionary, 0x2019, 1);
        put_number(dictionary, 0x2018, 1, temperature);
        let is_warm = temperature >= number(dictionary, 0x2018, 2);
        if is_warm != self.is_warm {
            self.is_warm = is_warm;
            self.asks.error = Some((WARM, is_warm));
        }
        self.is_hot = temperature >= number(dictionary, 0x2018, 3).min(HOTTEST);
    }

    /// 2712h: what a following error leads to.
    fn look_at_following<D: Dictionary>(&mut self, dictionary: &D) {
        let is_behind = self.statusword & IS_BEHIND != 0 && number(dictionary, 0x6061, 0) == 1;
        if is_behind == self.is_behind {
            return;
        }
        self.is_behind = is_behind;
        let code = number(dictionary, 0x2712, 0);
        if code == 4 {
            self.asks.error = Some((FOLLOWING_ERROR, is_behind));
        }
        self.is_disabled |= is_behind && matches!(code, 2 | 4);
    }
}

impl Behaviour for Module {
    fn power_on<D: Dictionary + Objects>(&mut self, dictionary: &mut D) {
        *self = Self::default();
        self.set_up(dictionary);
    }

    fn check<D: Dictionary + Objects>(
        &mut self,
        dictionary: &D,
        entry: &Entry,
        value: &[u8],
    ) -> Result<(), AbortCode> {
        let _ = (dictionary, value);
        // Bits 14 to 12 are 0.
        let is_known = entry.index != 0x2038
            || entry.sub != 1
            || value.get(1).is_none_or(|high| high & 0x70 == 0);
        is_known.then_some(()).ok_or(AbortCode::InvalidValue)
    }

    fn written<D: Dictionary + Objects>(&mut self, dictionary: &mut D, entry: &Entry) {
        match (entry.index, entry.sub) {
            (0x6040, _) => {
                let word = dictionary.controlword();
                self.is_disabled = false;
                if self.inhibit.controlword(word) & NEW_SET_POINT != 0
                    && self.is_enabled
                    && number(dictionary, 0x6061, 0) == 1
                {
                    self.take_set_point(dictionary, word);
                }
            }
            (0x2002 | 0x2004 | 0x2006 | 0x2034 | 0x2035, _) => self.set_up(dictionary),
            // All ones clear it.
            (0x2033, 2) => put_number(dictionary, 0x2033, 2, 0),
            (0x2031 | 0x2038, _) => {
                let has_trip = number(dictionary, 0x2031, 0) & HAS_TRIP != 0;
                self.trip.set_up(dictionary, has_trip);
                self.asks.commands = true;
            }
            _ => {}
        }
    }

    fn look<D: Dictionary + Objects>(&mut self, dictionary: &mut D, view: &View<'_>) {
        let actuals = view.actuals;
        if self.ticked.is_some_and(|last| actuals.at <= last) {
            // Nothing is new since the last tick, and a frame on a busy bus has no time to lose.
            return;
        }
        self.ticked = Some(actuals.at);
        self.since = self.since.saturating_add(1);
        self.statusword = actuals.statusword;
        self.position = actuals.position_actual;
        self.is_moving = actuals.is_moving;
        self.wires = actuals.digital_inputs >> 16;
        let was_enabled = self.is_enabled;
        let state = State::from_statusword(actuals.statusword);
        self.is_enabled = state == Some(State::OperationEnabled);
        if self.is_enabled && !was_enabled {
            self.since = SETTLED;
            for index in [0x2211, 0x2212] {
                put_number(dictionary, index, 0, self.position.into());
            }
        }
        if self.waits && self.since >= SETTLED && self.statusword & ACKNOWLEDGE == 0 {
            self.waits = false;
            let target = number(dictionary, 0x2212, 0);
            put_number(dictionary, 0x2211, 0, target);
        }
        let captures = number(dictionary, CAPTURES, 0);
        if captures != core::mem::replace(&mut self.captures, captures) {
            put_number(dictionary, 0x2033, 2, 1);
        }
        Self::show_analogue(dictionary);
        self.look_at_temperature(dictionary);
        self.look_at_following(dictionary);
        let is_changed = self.inhibit.look(dictionary, self.wires, view.at);
        let has_tripped = self.trip.look(actuals.at, actuals.position_demand.into());
        let code = number(dictionary, 0x2712, 0);
        let fault = if self.is_hot {
            Some(HOT)
        } else if self.is_behind && matches!(code, 3 | 5) {
            Some(FOLLOWING_ERROR)
        } else {
            self.inhibit.fault()
        };
        let is_new = fault != core::mem::replace(&mut self.fault, fault);
        self.asks.commands |= is_changed || has_tripped || is_new || self.is_disabled;
    }

    fn command<D: Dictionary + Objects>(
        &mut self,
        dictionary: &D,
        units: &Units,
        commands: &mut Commands,
    ) {
        let _ = units;
        if number(dictionary, 0x2031, 0) & HAS_TRIP != 0 {
            commands.touch_probe_function = 0;
            commands.touch_probes_off |= 1;
        }
        self.inhibit.command(commands);
        if self.is_disabled {
            commands.controlword &= !2;
        }
        commands.fault = self.fault;
        self.trip.command(commands);
    }

    fn asks(&mut self) -> Asks {
        core::mem::take(&mut self.asks)
    }
}
