//! An incremental encoder with index: a timer that counts, and a capture at the index.
//!
//! The count of 16 bits wraps; the position of 64 goes on. The angle within an electrical turn is worked out of the count within a mechanical one,
//! exactly, however many turns it has gone; so is the position where a turn has another number of positions than the encoder has counts.
//! The first index is taken for where the turn begins; each that follows must come whole turns later,
//! within the tolerance for the two edges of an index.

use core::hint::cold_path;

use super::FeedbackFault;
use crate::{Angle, Motor};

/// See the module.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Incremental {
    counts: u32,
    /// In a turn, and those of a count in parts of 2³².
    positions: u32,
    scale: u64,
    pole_pairs: u16,
    /// Electrical turns of a count and of half of one, in parts of 2⁶⁴ of a turn; whole turns are left out.
    factor: u64,
    half: u64,
    /// How many counts an index may be off.
    tolerance: u32,
    /// −1 if the timer counts the other way, or 1.
    direction: i16,
    last: u16,
    /// The position where it began, or where the counts of a turn were set, and whole turns since: what is counted are these, and the count in the turn.
    begin: i64,
    turns: i64,
    in_turn: u32,
    /// The electrical angle of the middle of the count where that is 0, in parts of 2⁶⁴ of a turn.
    zero: u64,
    index: Option<i64>,
}

impl Incremental {
    /// For a motor that was checked, with the timer at this count. An index may be so many counts off.
    pub fn new(motor: &Motor, timer: u16, tolerance: u32) -> Self {
        let counts = motor.counts.max(1);
        let mut encoder = Self {
            counts,
            positions: counts,
            scale: 1 << 32,
            pole_pairs: 0,
            factor: 0,
            half: 0,
            tolerance,
            direction: 1,
            last: timer,
            begin: 0,
            turns: 0,
            in_turn: 0,
            zero: 0,
            index: None,
        };
        encoder.set_pole_pairs(motor.pole_pairs);
        encoder
    }

    /// The timer counts this now. More than 32,767 counts between two looks cannot be seen.
    #[inline(never)]
    pub fn look(&mut self, timer: u16) {
        self.look_at_once(timer);
    }

    /// The same where there is no time for a call.
    #[inline(always)]
    pub(crate) fn look_at_once(&mut self, timer: u16) {
        let moved = self.moved(self.last, timer);
        self.last = timer;
        let in_turn = self.in_turn.cast_signed() + moved;
        self.in_turn = in_turn.cast_unsigned();
        if self.in_turn >= self.counts {
            cold_path();
            // A look is less than a turn of most encoders; of a coarse one it may be several.
            let turn = self.counts.cast_signed();
            let left = in_turn.checked_rem_euclid(turn).unwrap_or(0);
            let turns = in_turn.wrapping_sub(left).checked_div(turn);
            self.turns = self.turns.wrapping_add(turns.unwrap_or(0).into());
            self.in_turn = left.cast_unsigned();
        }
    }

    /// Counts from one value of the timer to another.
    #[inline(always)]
    fn moved(&self, from: u16, to: u16) -> i32 {
        i32::from(to.wrapping_sub(from).cast_signed()) * i32::from(self.direction)
    }

    /// The index was passed with the timer at this count, at most half of its range ago.
    ///
    /// # Errors
    /// It is not whole turns away from the one before.
    pub fn index(&mut self, timer: u16) -> Result<(), FeedbackFault> {
        let since = self.moved(timer, self.last);
        let at = self.counted().wrapping_sub(since.into());
        let first = *self.index.get_or_insert(at);
        let turn = i64::from(self.counts);
        let off = at.wrapping_sub(first).checked_rem_euclid(turn);
        let off = off.map_or(0, |off| off.min(turn - off));
        if off > i64::from(self.tolerance) {
            return Err(FeedbackFault::CountsLost);
        }
        Ok(())
    }

    /// The first index, in counts from where it began; `None` before it was passed.
    pub fn index_position(&self) -> Option<i64> {
        self.index
    }

    /// Counts from where it began, or from where the counts of a turn were set.
    fn counted(&self) -> i64 {
        let turns = self.turns.wrapping_mul(self.counts.into());
        turns.wrapping_add(self.in_turn.into())
    }

    /// From where it began, in the counts of the motor.
    #[inline]
    pub fn position(&self) -> i64 {
        let in_turn = (u64::from(self.in_turn).wrapping_mul(self.scale) >> 32).cast_signed();
        let turns = self.turns.wrapping_mul(self.positions.into());
        self.begin.wrapping_add(turns).wrapping_add(in_turn)
    }

    /// The encoder has so many counts in a turn; positions stay those of the motor. It goes on from where it is, with the angle that it has.
    pub fn set_counts(&mut self, counts: u32) {
        let (position, angle) = (self.position(), self.angle());
        let counts = counts.clamp(1, 1 << 24);
        self.counts = counts;
        self.scale = (u64::from(self.positions) << 32).div_ceil(u64::from(counts));
        self.set_pole_pairs(self.pole_pairs);
        (self.turns, self.in_turn, self.index) = (0, 0, None);
        self.begin = position;
        self.set_angle(angle);
    }

    /// It is so many counts from where it began, with the timer at this count, and has the angle that it had.
    pub fn begin_at(&mut self, timer: u16, counted: i64) {
        let angle = self.angle();
        let turn = i64::from(self.counts);
        let in_turn = counted.checked_rem_euclid(turn).unwrap_or(0);
        self.turns = counted.checked_div_euclid(turn).unwrap_or(0);
        self.in_turn = in_turn as u32;
        (self.last, self.begin, self.index) = (timer, 0, None);
        self.set_angle(angle);
    }

    /// The electrical angle of the middle of the count, by the offset that was found.
    #[inline(never)]
    pub fn angle(&self) -> Angle {
        self.angle_at_once()
    }

    /// The same where there is no time for a call.
    #[inline(always)]
    pub(crate) fn angle_at_once(&self) -> Angle {
        let turned = u64::from(self.in_turn).wrapping_mul(self.factor);
        Angle::from_bits((turned.wrapping_add(self.zero) >> 32) as u32)
    }

    /// Other pole pairs, from where the count within the turn is 0.
    pub fn set_pole_pairs(&mut self, pole_pairs: u16) {
        self.pole_pairs = pole_pairs;
        let counts = u64::from(self.counts.max(1));
        // Of a half: the whole is that twice, and no more than a last bit off.
        let turns = u64::from(pole_pairs) << 31;
        let (whole, rest) = (turns / counts, turns % counts);
        let offset = self.zero.wrapping_sub(self.half);
        self.half = (whole << 32).wrapping_add((rest << 32) / counts);
        self.factor = self.half.wrapping_mul(2);
        self.zero = self.half.wrapping_add(offset);
    }

    /// Whether the timer counts the other way, from now on.
    pub fn turn(&mut self, is_turned: bool) {
        self.direction = if is_turned { -1 } else { 1 };
    }

    /// The electrical angle where the count within the turn is 0.
    pub fn offset(&self) -> Angle {
        Angle::from_bits((self.zero.wrapping_sub(self.half) >> 32) as u32)
    }

    /// The rotor stands at this electrical angle now.
    pub fn set_angle(&mut self, angle: Angle) {
        let by = angle.minus(self.angle());
        self.zero = self.zero.wrapping_add(u64::from(by.bits()) << 32);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motor::tests::servo_100w;
    use proptest::prelude::*;

    proptest! {
        /// After any way the angle is that of the position, to the last bits.
        #[test]
        fn the_angle_is_that_of_the_position(
            moves in prop::collection::vec(any::<i16>(), 1..200),
            counts in 16..100_000_u32,
            pole_pairs in 1..=100_u16,
        ) {
            let motor = Motor { counts, pole_pairs, ..servo_100w() };
            let mut encoder = Incremental::new(&motor, 77, 2);
            let (mut timer, mut position) = (77_u16, 0_i64);
            for moved in moves {
                timer = timer.wrapping_add_signed(moved);
                position += i64::from(moved);
                encoder.look(timer);
                prop_assert_eq!(encoder.position(), position);
                let turns = (position.rem_euclid(counts.into()) as f64 + 0.5) * f64::from(pole_pairs) / f64::from(counts);
                let exact = Angle::from_bits((turns.fract() * 4_294_967_296.0) as u32);
                prop_assert!(encoder.angle().minus(exact).turns().abs() < 1e-5);
            }
        }
    }

    proptest! {
        /// Where the encoder has another number of counts than the turn positions, both are exact at each count, whatever the way.
        #[test]
        fn positions_are_those_of_the_motor_whatever_the_encoder_counts(
            moves in prop::collection::vec(any::<i16>(), 1..200),
            counts in 16..100_000_u32,
            positions in 16..1_000_000_u32,
        ) {
            let motor = Motor { counts: positions, ..servo_100w() };
            let mut encoder = Incremental::new(&motor, 77, 2);
            encoder.set_counts(counts);
            let (mut timer, mut counted) = (77_u16, 0_i64);
            for moved in moves {
                timer = timer.wrapping_add_signed(moved);
                counted += i64::from(moved);
                encoder.look(timer);
                let exact = (counted * i64::from(positions)).div_euclid(counts.into());
                prop_assert_eq!(encoder.position(), exact);
                let turns = (counted.rem_euclid(counts.into()) as f64 + 0.5) * 4.0 / f64::from(counts);
                let angle = Angle::from_bits((turns.fract() * 4_294_967_296.0) as u32);
                // It began in the middle of a count of the motor.
                let begun = Angle::from_turns(2.0 / positions as f32 - 2.0 / counts as f32);
                prop_assert!(encoder.angle().minus(angle).minus(begun).turns().abs() < 1e-5);
            }
            let (position, angle) = (encoder.position(), encoder.angle());
            encoder.set_counts(positions);
            prop_assert_eq!((encoder.position(), encoder.angle()), (position, angle));
            encoder.look(timer.wrapping_add(9));
            prop_assert_eq!(encoder.position(), position + 9);
        }
    }

    #[test]
    fn it_begins_at_any_count_with_the_angle_that_it_had() {
        let motor = servo_100w();
        for (positions, counted, position) in [
            (10_000, 47_301, 47_301),
            (10_000, -2_501, -2_501),
            (40_000, 47_301, 189_204),
        ] {
            let motor = Motor {
                counts: positions,
                ..motor
            };
            let mut encoder = Incremental::new(&motor, 0, 2);
            encoder.set_counts(10_000);
            encoder.look(1_234);
            encoder.set_angle(Angle::QUARTER);
            encoder.begin_at(60_000, counted);
            assert_eq!(encoder.angle(), Angle::QUARTER);
            assert_eq!(encoder.position(), position);
            // Whole turns later the angle is the same, and the position goes on.
            encoder.look(60_000_u16.wrapping_add(10_000));
            assert_eq!(encoder.angle(), Angle::QUARTER);
            assert_eq!(encoder.position(), position + i64::from(positions));
        }
    }

    #[test]
    fn an_index_comes_whole_turns_after_the_first() {
        let motor = Motor {
            counts: 1_000,
            ..servo_100w()
        };
        let mut encoder = Incremental::new(&motor, 0, 2);
        encoder.look(130);
        encoder.index(100).unwrap();
        assert_eq!(encoder.index_position(), Some(100));
        encoder.look(1_105);
        encoder.index(1_102).unwrap();
        encoder.look(65_536u32.wrapping_sub(890) as u16);
        encoder.index(0u16.wrapping_sub(899)).unwrap();
        assert_eq!(
            encoder.index(0u16.wrapping_sub(897)),
            Err(FeedbackFault::CountsLost)
        );
    }

    #[test]
    fn an_offset_holds_for_whole_turns() {
        let motor = servo_100w();
        let mut encoder = Incremental::new(&motor, 0, 2);
        encoder.look(1_234);
        encoder.set_angle(Angle::QUARTER);
        assert_eq!(encoder.angle(), Angle::QUARTER);
        for turn in 1..=20_u16 {
            encoder.look(1_234_u16.wrapping_add(turn.wrapping_mul(10_000)));
            assert_eq!(encoder.angle(), Angle::QUARTER, "after {turn} turns");
        }
    }
}
