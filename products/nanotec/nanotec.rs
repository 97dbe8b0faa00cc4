//! What the Nanotec does that is no data: the level of its home switch by the method, its detector of blocks, an abrupt quick stop in interpolated
//! position, the swing-out time, and modes that wait for the brake.

use canopen::Instant;
use canopen::cia301::sdo::AbortCode;
use canopen::od::{self, Dictionary, Entry};
use cia402::behaviour::{Asks, Behaviour, View, number, put_number};
use cia402::commands::Commands;
use cia402::units::Units;
use cia402::{Objects, State};

/// Objects of our own, which parameters of the drive are read from.
const INVERTED: u16 = 0x5F00;
const BLOCK_WINDOW: u16 = 0x5F01;
const BLOCK_TIME: u16 = 0x5F02;
const QUICK_STOP: u16 = 0x5F03;

/// The home switch is input 6.
const HOME_SWITCH: i64 = 1 << 5;

/// A block where 6065h and 6066h say nothing: an electrical revolution, in ms.
const BLOCK: (i64, i64) = (40, 50);

const INTERPOLATED_POSITION: i64 = 7;

/// The outputs that 60FEh:2 has bits for.
const OUTPUTS: i64 = 0x0007_0000;

/// 6041h.
const REACHED: i64 = 1 << 10;

/// The module.
#[derive(Debug)]
pub struct Module {
    asks: Asks,
    is_enabled: bool,
    /// Since when operation is enabled, and since when the motor stands.
    enabled: Instant,
    stands: Option<Instant>,
    at: Instant,
    /// The mode in force before the brake was to be waited for.
    mode: i8,
    /// The brake is being waited for.
    waits: bool,
    /// Bit 10 waits for the swing-out time.
    swings: bool,
    ticked: Instant,
}

impl Default for Module {
    fn default() -> Self {
        Self {
            asks: Asks::default(),
            is_enabled: false,
            enabled: Instant::from_ticks(0),
            stands: None,
            at: Instant::from_ticks(0),
            mode: 0,
            waits: false,
            swings: false,
            ticked: Instant::from_ticks(0),
        }
    }
}

impl Module {
    /// What hangs on the set-up.
    fn set_up<D: Dictionary>(&mut self, dictionary: &mut D) {
        let opens = matches!(number(dictionary, 0x6098, 0), 19 | 21);
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
        ] {
            put_number(dictionary, index, 0, value);
        }
        self.asks.configuration = true;
    }

    /// The drive has published what it does.
    fn tick<D: Dictionary>(&mut self, dictionary: &D, view: &View<'_>) {
        let actuals = view.actuals;
        self.at = view.at;
        let was_enabled = self.is_enabled;
        let state = State::from_statusword(actuals.statusword);
        self.is_enabled = state == Some(State::OperationEnabled);
        let release_time = u64::try_from(number(dictionary, 0x2007, 2)).unwrap_or(0) * 1_000;
        if self.is_enabled && !was_enabled {
            self.enabled = view.at;
        }
        let waits = self.is_enabled && self.since(self.enabled) < release_time;
        // The mode that was asked for meanwhile is taken behind it.
        self.asks.commands |= self.waits && !waits;
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
        self.swings = actuals.mode_display == 1 && self.is_enabled && swings;
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
            (0x6085, _) if value == 0 => Err(AbortCode::ValueTooLow),
            _ => Ok(()),
        }
    }

    fn written<D: Dictionary + Objects>(&mut self, dictionary: &mut D, entry: &Entry) {
        if matches!(entry.index, 0x6060 | 0x6065 | 0x6066 | 0x6085 | 0x6098) {
            self.set_up(dictionary);
        }
    }

    fn look<D: Dictionary + Objects>(&mut self, dictionary: &mut D, view: &View<'_>) {
        if view.actuals.at > self.ticked {
            self.ticked = view.actuals.at;
            self.tick(dictionary, view);
        }
        if self.swings {
            let word = number(dictionary, 0x6041, 0);
            put_number(dictionary, 0x6041, 0, word & !REACHED);
        }
    }

    fn command<D: Dictionary + Objects>(
        &mut self,
        dictionary: &D,
        units: &Units,
        commands: &mut Commands,
    ) {
        let _ = (dictionary, units);
        if self.waits {
            commands.mode = self.mode;
        }
    }

    fn asks(&mut self) -> Asks {
        core::mem::take(&mut self.asks)
    }
}
