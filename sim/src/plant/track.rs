//! What lies along the axis: switches, index pulses, end stops.

use std::ops::RangeInclusive;

use super::chance::Chance;
use super::contact::{Contact, Sensed, Switch};

/// The inputs of the drive that the plant is wired to: 1 negative limit, 2 positive limit, 3 home switch, 4 index, 5 and 6 touch
/// probes.
pub const WIRES: usize = 6;

/// What is mounted along the axis. Positions are in steps, from where the motor stood at its first power-on unless the
/// axis says otherwise.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Track {
    /// The negative limit switch, on input 1.
    pub negative_limit: Option<Switch>,
    /// The positive limit switch, on input 2.
    pub positive_limit: Option<Switch>,
    /// The home switch, on input 3.
    pub home: Option<Switch>,
    /// The index pulses, on input 4.
    pub index: Option<Index>,
    /// What touch probes 1 and 2 meet, on inputs 5 and 6.
    pub probes: [Option<Switch>; 2],
    /// The axis cannot leave this range: beyond it pulses are lost.
    pub stops: Option<RangeInclusive<i64>>,
    /// The axis is round: the switches are there again after so many steps.
    pub turn: Option<u32>,
}

/// Index pulses: one at `first`, and one every `distance` steps from there in both directions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Index {
    /// One of them.
    pub first: i64,
    /// From one to the next, at least 1.
    pub distance: u32,
    /// A pulse begins at its position and is so many steps wide.
    pub width: u32,
}

impl Index {
    /// Pulses of one step.
    pub const fn new(first: i64, distance: u32) -> Self {
        Self {
            first,
            distance,
            width: 1,
        }
    }

    fn is_at(&self, position: i64) -> bool {
        let behind = (position - self.first).rem_euclid(i64::from(self.distance.max(1)));
        behind < i64::from(self.width)
    }
}

/// Which switches are active.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SwitchStates {
    /// The negative limit switch.
    pub negative_limit: bool,
    /// The positive limit switch.
    pub positive_limit: bool,
    /// The home switch.
    pub home: bool,
}

/// The track at work.
#[derive(Clone, Debug, Default)]
pub(super) struct Surroundings {
    /// Negative limit, positive limit, home, touch probes 1 and 2.
    contacts: [Option<Contact>; 5],
    index: Option<Index>,
    index_wire: Sensed,
    stops: Option<RangeInclusive<i64>>,
    turn: Option<u32>,
    /// Decides how contacts bounce.
    chance: Chance,
}

impl Surroundings {
    /// What is mounted, with the axis at `position`.
    pub(super) fn new(track: &Track, position: i64, seed: u64) -> Self {
        let place = around(track.turn, position);
        let contact =
            |switch: &Option<Switch>| switch.clone().map(|switch| Contact::new(switch, place));
        Self {
            contacts: [
                contact(&track.negative_limit),
                contact(&track.positive_limit),
                contact(&track.home),
                contact(&track.probes[0]),
                contact(&track.probes[1]),
            ],
            index: track.index,
            index_wire: Sensed {
                level: track.index.is_some_and(|index| index.is_at(position)),
                ..Sensed::default()
            },
            stops: track.stops.clone(),
            turn: track.turn,
            chance: Chance::new(seed),
        }
    }

    /// Whether the axis can be at a position.
    pub(super) fn is_free(&self, position: i64) -> bool {
        self.stops
            .as_ref()
            .is_none_or(|stops| stops.contains(&position))
    }

    /// Nothing is mounted that a step could change.
    pub(super) fn is_empty(&self) -> bool {
        self.contacts.iter().all(Option::is_none) && self.index.is_none() && self.stops.is_none()
    }

    /// The axis has come to `position` by one step; `seen` is what the drive counts there, and when that was in nanoseconds.
    pub(super) fn follow(&mut self, position: i64, seen: (i64, u64)) {
        let place = around(self.turn, position);
        for contact in self.contacts.iter_mut().flatten() {
            contact.follow(place, seen, &mut self.chance);
        }
        if let Some(index) = self.index {
            self.index_wire.see(index.is_at(position), seen);
        }
    }

    /// What the inputs have seen since the last look.
    pub(super) fn look(&mut self, seen: (i64, u64)) -> [Sensed; WIRES] {
        let [negative_limit, positive_limit, home, probe_1, probe_2] =
            self.contacts.each_mut().map(|contact| match contact {
                Some(contact) => contact.look(seen),
                None => Sensed::default(),
            });
        let index = self.index_wire.take();
        [
            negative_limit,
            positive_limit,
            home,
            index,
            probe_1,
            probe_2,
        ]
    }

    pub(super) fn states(&self) -> SwitchStates {
        let [negative_limit, positive_limit, home, ..] = self
            .contacts
            .each_ref()
            .map(|contact| contact.as_ref().is_some_and(Contact::is_active));
        SwitchStates {
            negative_limit,
            positive_limit,
            home,
        }
    }
}

/// Where a position is on an axis that may be round.
fn around(turn: Option<u32>, position: i64) -> i64 {
    match turn {
        Some(turn) if turn > 0 => position.rem_euclid(turn.into()),
        _ => position,
    }
}
