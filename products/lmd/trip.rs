//! The trip output (2038h): a pulse where the demand passes a point, and then every so many microsteps. A board that compares positions itself makes it
//! with the very pulse of the motor; else it comes with the control tick behind that.

use canopen::Instant;
use canopen::od::Dictionary;
use cia402::Compare;
use cia402::behaviour::number;
use cia402::commands::Commands;

/// 2038h:1.
const ENABLE: i64 = 1 << 15;
const COUNT: i64 = 0x0FFF;

/// Output 3, in 60FEh.
const OUTPUT: u32 = 1 << 18;

/// Most points that one control tick may pass.
const MOST: usize = 64;

/// The output.
#[derive(Debug, Default)]
pub(super) struct Trip {
    is_enabled: bool,
    point: i64,
    spacing: i64,
    /// How many are left; none where there is no end.
    left: Option<i64>,
    before: Option<i64>,
    ticked: Option<Instant>,
    is_high: bool,
    /// For a board that compares positions.
    number: u8,
    has_compare: bool,
}

impl Trip {
    pub(super) fn set_up<D: Dictionary>(&mut self, dictionary: &D, has_trip: bool) {
        let control = number(dictionary, 0x2038, 1);
        let count = control & COUNT;
        *self = Self {
            is_enabled: has_trip && control & ENABLE != 0,
            point: number(dictionary, 0x2038, 2),
            spacing: number(dictionary, 0x2038, 3),
            left: (count != 0).then_some(count),
            number: self.number.wrapping_add(1),
            has_compare: self.has_compare,
            ..Self::default()
        };
    }

    /// Looks where the demand is. Returns whether the output is another one now.
    pub(super) fn look(&mut self, ticked: Instant, demand: i64, has_compare: bool) -> bool {
        self.has_compare = has_compare;
        if has_compare || !self.is_enabled || self.ticked.replace(ticked) == Some(ticked) {
            return false;
        }
        let before = self.before.replace(demand).unwrap_or(demand);
        let was_high = core::mem::take(&mut self.is_high);
        for _ in 0..MOST {
            let (low, high) = (before.min(demand), before.max(demand));
            // It comes to a point, or beyond it; what it leaves was passed in the tick before.
            let is_passed = (low..=high).contains(&self.point) && self.point != before;
            if !is_passed || self.left == Some(0) {
                break;
            }
            self.is_high = true;
            self.left = self.left.map(|left| left - 1);
            self.point += self.spacing;
            if self.spacing == 0 {
                break;
            }
        }
        was_high != self.is_high
    }

    pub(super) fn command(&self, commands: &mut Commands) {
        if self.is_enabled && self.has_compare {
            let least = |number: i64| number as i32;
            commands.compare = Some(Compare {
                position: least(self.point),
                spacing: least(self.spacing),
                count: self.left.unwrap_or(0) as u16,
                number: self.number,
                output: (OUTPUT >> 16) as u8,
            });
        } else if self.is_enabled {
            let level = if self.is_high { OUTPUT } else { 0 };
            commands.digital_outputs = commands.digital_outputs & !OUTPUT | level;
            commands.digital_outputs_mask |= OUTPUT;
            commands.outputs_written = true;
        }
    }
}
