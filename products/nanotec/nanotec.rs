//! What the Nanotec does that is no data: where its home switch is and which level it has by the method, its detector of blocks and its current for
//! them, an abrupt quick stop in interpolated position, the swing-out time, modes that wait for the brake, what outputs show, inputs, and its closed loop.

mod closed_loop;
mod inputs;

use canopen::Instant;
use canopen::cia301::sdo::AbortCode;
use canopen::od::{self, Dictionary, Entry};
use cia402::behaviour::{Behaviour, Requests, View, number, put_number};
use cia402::commands::Commands;
use cia402::loops::{LoopReport, Request, ServoSettings};
use cia402::units::Units;
use cia402::{Objects, State};

use closed_loop::{ClosedLoop, WINDOW, hall_order};
use inputs::{Debounce, Trigger};

/// Objects of our own, which parameters of the drive are read from.
const INVERTED: u16 = 0x5F00;
const BLOCK_WINDOW: u16 = 0x5F01;
const BLOCK_TIME: u16 = 0x5F02;
const QUICK_STOP: u16 = 0x5F03;
const RUN_CURRENT: u16 = 0x5F04;

/// The home switch is input 6.
const HOME_SWITCH: i64 = 1 << 5;

/// A block where 6065h and 6066h say nothing: an electrical revolution, in ms.
const BLOCK: (i64, i64) = (40, 50);

const INTERPOLATED_POSITION: i64 = 7;

/// The outputs that 60FEh:2 has bits for. Those with a bit of 1 show that the motor moves, that the target is reached, and an error.
const OUTPUTS: i64 = 0x0007_0000;
const FIRST_OUTPUT: u32 = 16;
const SHOWN: [(u16, i64); 3] = [(0x5F05, 6), (0x5F06, 4), (0x5F07, 1)];

/// 6041h.
const REACHED: i64 = 1 << 10;
const ATTAINED: i64 = 1 << 12;
const HOMING_ERROR: i64 = 1 << 13;

const HOMING: i8 = 6;

/// The module.
#[derive(Debug)]
pub struct Module {
    closed_loop: ClosedLoop,
    requests: Requests,
    is_enabled: bool,
    /// Since when operation is enabled, and since when the motor stands.
    enabled: Instant,
    stands: Option<Instant>,
    at: Instant,
    /// The mode in force before the brake was to be waited for.
    mode: i8,
    /// The brake is being waited for.
    waits: bool,
    /// Bits of the statusword that wait for the swing-out time.
    swings: i64,
    ticked: Instant,
    debounce: Debounce,
    trigger: Trigger,
    /// The motor looks for a block.
    seeks_block: bool,
}

impl Default for Module {
    fn default() -> Self {
        Self {
            closed_loop: ClosedLoop::default(),
            requests: Requests::default(),
            is_enabled: false,
            enabled: Instant::from_ticks(0),
            stands: None,
            at: Instant::from_ticks(0),
            mode: 0,
            waits: false,
            swings: 0,
            ticked: Instant::from_ticks(0),
            debounce: Debounce::default(),
            trigger: Trigger::default(),
            seeks_block: false,
        }
    }
}

impl Module {
    /// What hangs on the set-up.
    fn set_up<D: Dictionary>(&mut self, dictionary: &mut D) {
        let opens = matches!(number(dictionary, 0x6098, 0), 19 | 21 | -4 | -6);
        let current = match number(dictionary, 0x2004, 4) {
            percent @ 1.. if self.seeks_block => percent,
            _ => number(dictionary, 0x2004, 1),
        };
        let window = match number(dictionary, 0x6065, 0) {
            0 | 0xFFFF_FFFF => BLOCK,
            window => (window, number(dictionary, 0x6066, 0).max(1)),
        };
        let is_abrupt = number(dictionary, 0x6060, 0) == INTERPOLATED_POSITION;
        let ramp = if is_abrupt {
            u32::MAX.into()
        } else {
            number(dictionary, 0x6085, 0)
        };
        for (index, value) in [
            (INVERTED, if opens { HOME_SWITCH } else { 0 }),
            (BLOCK_WINDOW, window.0),
            (BLOCK_TIME, window.1),
            (QUICK_STOP, ramp),
            (RUN_CURRENT, current),
            (WINDOW, self.closed_loop.window(dictionary)),
        ] {
            put_number(dictionary, index, 0, value);
        }
        let mut own = number(dictionary, 0x60FE, 2) >> FIRST_OUTPUT;
        for (index, function) in SHOWN {
            put_number(dictionary, index, 0, (own & 1) * function);
            own >>= 1;
        }
        self.requests.configuration = true;
    }

    /// The drive has published what it does.
    fn tick<D: Dictionary>(&mut self, dictionary: &mut D, view: &View<'_>) {
        let actuals = view.actuals;
        self.closed_loop
            .tick(actuals.is_moving, actuals.following_error);
        self.at = view.at;
        let was_enabled = self.is_enabled;
        let state = State::from_statusword(actuals.statusword);
        self.is_enabled = state == Some(State::OperationEnabled);
        let release_time = number(dictionary, 0x2007, 1) + number(dictionary, 0x2007, 2);
        let release_time = u64::try_from(release_time).unwrap_or(0) * 1_000;
        if self.is_enabled && !was_enabled {
            self.enabled = view.at;
        }
        let waits = self.is_enabled && self.since(self.enabled) < release_time;
        // The mode that was asked for meanwhile is taken behind it.
        self.requests.commands |= self.waits && !waits;
        self.waits = waits;
        if !waits {
            self.mode = actuals.mode_display;
        }
        // Set-points are ready when the motor has swung out.
        if actuals.is_moving {
            self.stands = None;
        } else if self.stands.is_none() {
            self.stands = Some(view.at);
        }
        let time = u64::try_from(number(dictionary, 0x2004, 5)).unwrap_or(0) * 1_000;
        let swings = self.stands.is_none_or(|then| self.since(then) < time);
        let is_block_run = matches!(number(dictionary, 0x6098, 0), -3 | -2);
        let waits = match actuals.mode_display {
            1 => REACHED,
            HOMING if is_block_run => REACHED | ATTAINED,
            _ => 0,
        };
        self.swings = if self.is_enabled && swings { waits } else { 0 };
        let is_homing = actuals.mode_display == HOMING && self.is_enabled && {
            let bits = i64::from(actuals.statusword) & (ATTAINED | HOMING_ERROR);
            number(dictionary, 0x6040, 0) & 0x10 != 0 && bits == 0
        };
        let seeks_block = is_homing && is_block_run;
        if seeks_block != core::mem::replace(&mut self.seeks_block, seeks_block) {
            self.set_up(dictionary);
        }
        let wires = u8::try_from(actuals.digital_inputs >> 16).unwrap_or(0);
        self.debounce.look(dictionary, wires, view.at.ticks());
    }

    /// Microseconds since then.
    fn since(&self, then: Instant) -> u64 {
        let span = self.at.checked_duration_since(then);
        span.map_or(0, |span| span.ticks())
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
        let _ = dictionary;
        let value = od::number(entry, value).unwrap_or(0);
        match (entry.index, entry.sub) {
            // A bit without an output voids the whole mask.
            (0x60FE, 2) if value & !OUTPUTS != 0 => Err(AbortCode::InvalidValue),
            (0x2004, 12) if hall_order(value).is_none() => Err(AbortCode::InvalidValue),
            (0x6085, _) if value == 0 => Err(AbortCode::ValueTooLow),
            _ => Ok(()),
        }
    }

    fn written<D: Dictionary + Objects>(&mut self, dictionary: &mut D, entry: &Entry) {
        if entry.index == 0x6060 {
            self.closed_loop.choose(dictionary);
        }
        match entry.index {
            0x2004 | 0x6060 | 0x6065..=0x6067 | 0x6085 | 0x6098 | 0x60FE => {
                self.set_up(dictionary);
            }
            0x2010 => self.requests.commands = true,
            _ => {}
        }
    }

    fn look<D: Dictionary + Objects>(&mut self, dictionary: &mut D, view: &View<'_>) {
        if view.actuals.at > self.ticked {
            self.ticked = view.actuals.at;
            self.tick(dictionary, view);
        }
        self.debounce.show(dictionary);
        self.trigger.show(dictionary, view.serves_frame);
        if let Some(run) = self.closed_loop.run() {
            put_number(dictionary, 0x6061, 0, run);
        }
        if self.swings != 0 {
            let word = number(dictionary, 0x6041, 0);
            put_number(dictionary, 0x6041, 0, word & !self.swings);
        }
    }

    fn command<D: Dictionary + Objects>(
        &mut self,
        dictionary: &D,
        units: &Units,
        commands: &mut Commands,
    ) {
        let _ = units;
        if self.waits {
            commands.mode = self.mode;
        }
        if matches!(number(dictionary, 0x6098, 0), -7..=-4) && commands.mode == HOMING {
            let bit = number(dictionary, 0x2010, 1).clamp(0, 63);
            commands.home_switch = Some(number(dictionary, 0x2010, 2) >> bit & 1 != 0);
        }
    }

    fn loops<D: Dictionary + Objects>(
        &mut self,
        dictionary: &mut D,
        report: &LoopReport,
        settings: &mut ServoSettings,
    ) -> Option<Request> {
        let request = self.closed_loop.loops(dictionary, report, settings);
        self.requests.configuration |= self.closed_loop.limit(dictionary, report);
        request
    }

    fn take_requests(&mut self) -> Requests {
        core::mem::take(&mut self.requests)
    }
}
