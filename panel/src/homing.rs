//! Homing methods (CiA 402-2, homing mode) as a drawing needs them: which switch is looked for, where it is active, where home lies.

use serde::Serialize;

/// Where a switch is active on the axis, from the negative end to the positive one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Switch {
    /// The negative limit switch.
    NegativeLimit,
    /// The positive limit switch.
    PositiveLimit,
    /// A home switch, active from its edge to the positive end.
    HomePositive,
    /// A home switch, active from the negative end to its edge.
    HomeNegative,
    /// A home switch that is active in the middle.
    HomeMiddle,
    /// A hard stop at the negative end.
    NegativeStop,
    /// A hard stop at the positive end.
    PositiveStop,
    /// None.
    None,
}

/// A homing method.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Method {
    /// 6098h.
    pub number: i8,
    /// What a person calls it.
    pub words: &'static str,
    /// What is looked for.
    pub switch: Switch,
    /// Which way it sets out: 1 positive, -1 negative, 0 not at all.
    pub start: i8,
    /// Which edge of the switch counts: 1 the one towards the positive end, -1 the other one.
    pub edge: i8,
    /// On which side of the edge home is: 1 positive, -1 negative, 0 at the edge itself or where it stands.
    pub side: i8,
    /// Whether home is the next index pulse there.
    pub index: bool,
}

/// The methods without index pulse: number, words, switch, start, edge, side of the edge.
type Row = (i8, &'static str, Switch, i8, i8, i8);
const ROWS: [Row; 14] = [
    (17, "Negative limit switch", Switch::NegativeLimit, -1, 1, 1),
    (
        18,
        "Positive limit switch",
        Switch::PositiveLimit,
        1,
        -1,
        -1,
    ),
    (
        19,
        "Home switch towards the positive end, left of its edge",
        Switch::HomePositive,
        1,
        -1,
        -1,
    ),
    (
        20,
        "Home switch towards the positive end, right of its edge",
        Switch::HomePositive,
        1,
        -1,
        1,
    ),
    (
        21,
        "Home switch towards the negative end, right of its edge",
        Switch::HomeNegative,
        -1,
        1,
        1,
    ),
    (
        22,
        "Home switch towards the negative end, left of its edge",
        Switch::HomeNegative,
        -1,
        1,
        -1,
    ),
    (
        23,
        "Home switch from the left, before its left edge",
        Switch::HomeMiddle,
        1,
        -1,
        -1,
    ),
    (
        24,
        "Home switch from the left, behind its left edge",
        Switch::HomeMiddle,
        1,
        -1,
        1,
    ),
    (
        25,
        "Home switch from the left, before its right edge",
        Switch::HomeMiddle,
        1,
        1,
        -1,
    ),
    (
        26,
        "Home switch from the left, behind its right edge",
        Switch::HomeMiddle,
        1,
        1,
        1,
    ),
    (
        27,
        "Home switch from the right, before its right edge",
        Switch::HomeMiddle,
        -1,
        1,
        1,
    ),
    (
        28,
        "Home switch from the right, behind its right edge",
        Switch::HomeMiddle,
        -1,
        1,
        -1,
    ),
    (
        29,
        "Home switch from the right, before its left edge",
        Switch::HomeMiddle,
        -1,
        -1,
        1,
    ),
    (
        30,
        "Home switch from the right, behind its left edge",
        Switch::HomeMiddle,
        -1,
        -1,
        -1,
    ),
];

/// Those that have no twin with or without index pulse.
const OTHERS: [Row; 7] = [
    (33, "Next index pulse, negative", Switch::None, -1, 0, -1),
    (34, "Next index pulse, positive", Switch::None, 1, 0, 1),
    (35, "Where it stands", Switch::None, 0, 0, 0),
    (37, "Where it stands", Switch::None, 0, 0, 0),
    (-4, "Negative hard stop", Switch::NegativeStop, -1, 1, 0),
    (-3, "Positive hard stop", Switch::PositiveStop, 1, -1, 0),
    (0, "No homing", Switch::None, 0, 0, 0),
];

/// A method by its number; one that is not in the standard has a number alone.
pub fn method(number: i8) -> Method {
    let without_index = match number {
        1..=14 => number + 16,
        -2 | -1 => number - 2,
        other => other,
    };
    let mut rows = ROWS.iter().chain(&OTHERS);
    let row = rows.find(|row| row.0 == without_index);
    let (_, words, switch, start, edge, side) =
        *row.unwrap_or(&(0, "Of the manufacturer", Switch::None, 0, 0, 0));
    // The hard stop with its index pulse: the way back from it.
    let back = if number < 0 { -start } else { side };
    let index = without_index != number || matches!(number, 33 | 34);
    Method {
        number,
        words,
        switch,
        start,
        edge,
        side: if index { back } else { side },
        index,
    }
}

/// What can be chosen where a drive does not tell (60E3h).
pub fn standard() -> Vec<Method> {
    let numbers = (1..=14).chain(17..=30).chain([33, 34, 35, 37]);
    numbers.map(method).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_method_with_index_pulse_is_the_one_without_and_a_pulse() {
        for number in 1..=14 {
            let (with, without) = (method(number), method(number + 16));
            assert!(with.index && !without.index);
            assert_eq!(
                (with.switch, with.start, with.edge, with.side),
                (without.switch, without.start, without.edge, without.side)
            );
        }
        let limit = method(1);
        assert_eq!(
            (limit.switch, limit.start, limit.side),
            (Switch::NegativeLimit, -1, 1)
        );
        assert_eq!(
            (method(-2).switch, method(-2).side),
            (Switch::NegativeStop, 1)
        );
        assert_eq!(method(-100).words, "Of the manufacturer");
        assert_eq!(standard().len(), 32);
    }
}
