//! The range of positions 607Bh, and the ways round on a rotary axis (60F2h, bits 7 and 6).

use motion::low;

/// Where positions wrap. Without a range of their own they wrap at the ends of 32 bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Range {
    low: i32,
    high: i32,
}

/// In which direction a rotary axis goes to an absolute target, 60F2h bits 7 and 6.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rotation {
    /// 0: as on a linear axis, within the turn in which the axis stands. A target outside of the range is turns away.
    Linear,
    /// 1: in negative direction only.
    Negative,
    /// 2: in positive direction only.
    Positive,
    /// 3: the shorter distance; of two that are equally long the positive one.
    Shortest,
}

impl Rotation {
    /// The direction that 60F2h asks for.
    pub const fn of(positioning_option: u16) -> Self {
        match positioning_option >> 6 & 3 {
            0 => Self::Linear,
            1 => Self::Negative,
            2 => Self::Positive,
            _ => Self::Shortest,
        }
    }
}

impl Range {
    /// All of 32 bits.
    pub const ALL: Self = Self {
        low: i32::MIN,
        high: i32::MAX,
    };

    /// The range from a least to a greatest position; the one after the greatest is the least again. All of 32 bits, while the
    /// first is not below the second.
    pub const fn new((low, high): (i32, i32)) -> Self {
        if low < high {
            Self { low, high }
        } else {
            Self::ALL
        }
    }

    /// Whether the axis is rotary: positions have a range of their own.
    pub const fn is_rotary(self) -> bool {
        self.low != i32::MIN || self.high != i32::MAX
    }

    /// How many positions there are in a turn: 2 to 2³².
    #[allow(clippy::cast_lossless, reason = "From is not const; both casts widen")]
    pub const fn span(self) -> i64 {
        (self.high as i64)
            .wrapping_sub(self.low as i64)
            .wrapping_add(1)
    }

    /// A position as it is shown.
    #[inline]
    pub fn shown(self, position: i64) -> i32 {
        match i32::try_from(position) {
            Ok(position) if self.low <= position && position <= self.high => position,
            _ => self.wrapped(position),
        }
    }

    /// The beginning of the turn that a position lies in: what the position has beyond the one that is shown.
    #[inline(never)]
    pub fn turn(self, position: i64) -> i64 {
        position.wrapping_sub(self.shown(position).into())
    }

    /// Where targets may be for an axis that is at `position`: on a rotary axis anywhere, on a linear one what 32 bits hold.
    pub fn within_reach(self, position: i64) -> (i64, i64) {
        if self.is_rotary() {
            return (i64::MIN, i64::MAX);
        }
        let turn = self.turn(position);
        (
            turn.saturating_add(self.low.into()),
            turn.saturating_add(self.high.into()),
        )
    }

    #[cold]
    #[inline(never)]
    fn wrapped(self, position: i64) -> i32 {
        if !self.is_rotary() {
            return low::i32(position);
        }
        let beyond = position.wrapping_sub(self.low.into());
        let rest = beyond.checked_rem_euclid(self.span()).unwrap_or(0);
        // Not above the highest.
        low::i32(rest.wrapping_add(self.low.into()))
    }

    /// The target on the count that goes on behind the ends, for the position `target` of a turn and a motor that would come
    /// to rest at `from`.
    pub fn target(self, target: i64, from: i64, rotation: Rotation) -> i64 {
        let ahead = |from: i64, to: i64| {
            to.wrapping_sub(from)
                .checked_rem_euclid(self.span())
                .unwrap_or(0)
        };
        match rotation {
            _ if !self.is_rotary() => self.turn(from).saturating_add(target),
            Rotation::Linear => self.turn(from).saturating_add(target),
            Rotation::Negative => from.saturating_sub(ahead(target, from)),
            Rotation::Positive => from.saturating_add(ahead(from, target)),
            Rotation::Shortest => self.nearest(target, from),
        }
    }

    /// The position that is shown like `position` and lies nearest to `to`; of two that are equally far the greater one.
    pub fn nearest(self, position: i64, to: i64) -> i64 {
        let span = self.span();
        let half = span >> 1;
        let away = position.saturating_sub(to);
        if -half < away && away <= half {
            return position;
        }
        let ahead = position
            .wrapping_sub(to)
            .checked_rem_euclid(span)
            .unwrap_or(0);
        if ahead > half {
            to.saturating_add(ahead).saturating_sub(span)
        } else {
            to.saturating_add(ahead)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const DEGREES: Range = Range { low: 0, high: 359 };

    #[test]
    fn m59_positions_wrap_at_the_ends() {
        let shown = |position| DEGREES.shown(position);
        assert_eq!([shown(0), shown(359), shown(360)], [0, 359, 0]);
        assert_eq!([shown(-1), shown(-360), shown(725)], [359, 0, 5]);
        assert_eq!((DEGREES.turn(725), DEGREES.turn(-1)), (720, -360));
        let about = Range::new((-180, 179));
        assert_eq!([about.shown(180), about.shown(-181)], [-180, 179]);
        assert_eq!(Range::ALL.shown(1 << 31), i32::MIN);
        assert_eq!(Range::new((5, 5)), Range::ALL);
    }

    #[test]
    fn m59_from_350_to_10_degrees_there_are_four_ways() {
        let target = |code: u16| DEGREES.target(10, 350, Rotation::of(code << 6));
        assert_eq!(
            [target(0), target(1), target(2), target(3)],
            [10, 10, 370, 370]
        );
        let target = |code: u16| DEGREES.target(350, 370, Rotation::of(code << 6));
        assert_eq!(
            [target(0), target(1), target(2), target(3)],
            [710, 350, 710, 350]
        );
        let opposite = DEGREES.target(180, 0, Rotation::Shortest);
        assert_eq!(opposite, 180, "of two ways the positive one");
        assert_eq!(DEGREES.target(0, 180, Rotation::Shortest), 360);
    }

    proptest! {
        #[test]
        fn m59_the_short_way_is_at_most_half_a_range(
            low: i32, high: i32, target: i32, from in -(1_i64 << 40)..1 << 40,
        ) {
            let range = Range::new((low, high));
            let found = range.target(target.into(), from, Rotation::Shortest);
            if range.is_rotary() {
                prop_assert!((found - from).abs() <= range.span() / 2);
            }
            prop_assert_eq!(range.shown(found), range.shown(target.into()));
            prop_assert_eq!(range.turn(found) % range.span(), 0);
        }

        #[test]
        fn m59_one_direction_is_less_than_a_turn(
            low: i32, high: i32, target: i32, from in -(1_i64 << 40)..1 << 40,
        ) {
            let range = Range::new((low, high));
            prop_assume!(range.is_rotary());
            let up = range.target(target.into(), from, Rotation::Positive);
            let down = range.target(target.into(), from, Rotation::Negative);
            prop_assert!((0..range.span()).contains(&(up - from)));
            prop_assert!((0..range.span()).contains(&(from - down)));
            prop_assert_eq!(range.shown(up), range.shown(target.into()));
            prop_assert_eq!(range.shown(down), range.shown(target.into()));
        }

        #[test]
        fn m59_extremes_never_panic(low: i32, high: i32, target: i64, from: i64, code: u16) {
            let range = Range::new((low, high));
            let found = range.target(target, from, Rotation::of(code));
            range.shown(found);
            range.nearest(target, from);
        }
    }
}
