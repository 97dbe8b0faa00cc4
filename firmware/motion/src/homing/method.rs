//! The homing methods (CiA 402-2, "homing methods"), as one table.
//!
//! A switch is active in a range of positions: a limit switch from its edge to the end of travel, a home switch likewise or in
//! a window. A method names one end of that range, the direction of the last move and where the search begins; everything else
//! follows from these. With an index pulse, methods 1 to 14; the same without one, 17 to 30.

use crate::Direction;

/// A homing method, by its number in 6098h.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Method {
    code: i8,
    pub(super) reference: Reference,
    /// The home position is the first index pulse behind the reference.
    pub(super) index: bool,
}

/// What a method looks for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Reference {
    /// The edge of a switch.
    Switch(Approach),
    /// The next index pulse in this direction.
    Index(Direction),
    /// A hard stop in this direction.
    HardStop(Direction),
    /// Nothing: home is here.
    Here,
}

/// A switch that homing can refer to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Switch {
    NegativeLimit,
    PositiveLimit,
    Home,
}

/// An end of the range in which a switch is active.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum End {
    Lower,
    Upper,
}

impl End {
    /// The direction that leads out of the range here.
    pub(super) const fn outwards(self) -> Direction {
        match self {
            Self::Lower => Direction::Reverse,
            Self::Upper => Direction::Forward,
        }
    }

    /// The end where the switch has changed in a motion in `direction`.
    pub(super) const fn crossed(direction: Direction, became_active: bool) -> Self {
        match (direction, became_active) {
            (Direction::Forward, true) | (Direction::Reverse, false) => Self::Lower,
            (Direction::Forward, false) | (Direction::Reverse, true) => Self::Upper,
        }
    }
}

/// What a limit switch in the way of the search means.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum AtLimit {
    /// It is the switch that is looked for, or an error.
    Fail,
    /// The search turns round, once.
    Turn,
    /// An error, unless the settings say to turn round.
    AsSet,
}

/// How the edge of a switch is found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Approach {
    pub(super) switch: Switch,
    /// The edge that is home.
    pub(super) end: End,
    /// The switch becomes active in the last move; else it becomes inactive.
    pub(super) rising: bool,
    /// Where the search begins while the switch is inactive.
    pub(super) search: Direction,
    pub(super) at_limit: AtLimit,
}

impl Approach {
    /// The direction of the last move.
    pub(super) const fn last(&self) -> Direction {
        match (self.end, self.rising) {
            (End::Lower, true) | (End::Upper, false) => Direction::Forward,
            (End::Upper, true) | (End::Lower, false) => Direction::Reverse,
        }
    }
}

/// Methods 1 to 14, and 17 to 30 without an index pulse.
const APPROACHES: [Approach; 14] = {
    use AtLimit::{AsSet, Fail, Turn};
    use Direction::{Forward, Reverse};
    use End::{Lower, Upper};
    use Switch::{Home, NegativeLimit, PositiveLimit};
    const RISING: bool = true;
    const FALLING: bool = false;
    [
        approach(NegativeLimit, Upper, FALLING, Reverse, Fail),
        approach(PositiveLimit, Lower, FALLING, Forward, Fail),
        approach(Home, Lower, FALLING, Forward, AsSet),
        approach(Home, Lower, RISING, Forward, AsSet),
        approach(Home, Upper, FALLING, Reverse, AsSet),
        approach(Home, Upper, RISING, Reverse, AsSet),
        approach(Home, Lower, FALLING, Forward, Turn),
        approach(Home, Lower, RISING, Forward, Turn),
        approach(Home, Upper, RISING, Forward, Turn),
        approach(Home, Upper, FALLING, Forward, Turn),
        approach(Home, Upper, FALLING, Reverse, Turn),
        approach(Home, Upper, RISING, Reverse, Turn),
        approach(Home, Lower, RISING, Reverse, Turn),
        approach(Home, Lower, FALLING, Reverse, Turn),
    ]
};

const fn approach(
    switch: Switch,
    end: End,
    rising: bool,
    search: Direction,
    at_limit: AtLimit,
) -> Approach {
    Approach {
        switch,
        end,
        rising,
        search,
        at_limit,
    }
}

impl Method {
    /// Every number of 6098h that is a method here: 1 to 14, 17 to 30, 33, 34, 35, 37, and for hard stops -1 to -4.
    pub const CODES: [i8; 36] = [
        -4, -3, -2, -1, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 17, 18, 19, 20, 21, 22, 23,
        24, 25, 26, 27, 28, 29, 30, 33, 34, 35, 37,
    ];

    /// The method with this number in 6098h; `None` for numbers that are reserved, or mean no method (0).
    ///
    /// The standard has no numbers for hard stops. Here -1 and -3 run into the positive one, -2 and -4 into the negative one, -1
    /// and -2 go on to an index pulse.
    pub fn from_code(code: i8) -> Option<Self> {
        use Direction::{Forward, Reverse};
        let approach = |number: i8| {
            usize::try_from(number)
                .ok()
                .and_then(|number| APPROACHES.get(number))
                .map(|approach| Reference::Switch(*approach))
        };
        let (reference, index) = match code {
            1..=14 => (approach(code - 1)?, true),
            17..=30 => (approach(code - 17)?, false),
            33 => (Reference::Index(Reverse), true),
            34 => (Reference::Index(Forward), true),
            35 | 37 => (Reference::Here, false),
            -1 => (Reference::HardStop(Forward), true),
            -2 => (Reference::HardStop(Reverse), true),
            -3 => (Reference::HardStop(Forward), false),
            -4 => (Reference::HardStop(Reverse), false),
            _ => return None,
        };
        Some(Self {
            code,
            reference,
            index,
        })
    }

    /// Its number in 6098h.
    pub const fn code(self) -> i8 {
        self.code
    }

    /// Whether the motor does not move: home is where it stands (35 and 37).
    pub const fn is_immediate(self) -> bool {
        matches!(self.reference, Reference::Here)
    }

    /// A hard stop method that runs the other way; any other as it is.
    #[must_use]
    pub(super) const fn with_other_sign(mut self) -> Self {
        if let Reference::HardStop(direction) = self.reference {
            self.reference = Reference::HardStop(direction.reversed());
        }
        self
    }
}
