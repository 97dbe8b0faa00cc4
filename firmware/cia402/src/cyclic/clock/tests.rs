//! Several SYNCs for one set-point: where the slots are, and what comes in them.

use std::vec::Vec;

use canopen::Instant;

use super::*;

const CYCLE: u64 = 1_000;

/// A clock with a SYNC each millisecond.
struct Network {
    clock: NetworkClock,
    interpolation: u64,
    now: u64,
}

impl Network {
    /// With 60C2h in microseconds.
    fn new(interpolation: u64) -> Self {
        Self {
            clock: NetworkClock::new(),
            interpolation,
            now: 1_000_000,
        }
    }

    /// A SYNC with this set-point. Returns what is in the slot, if there is one.
    fn sync(&mut self, position: Option<i32>) -> Option<Option<i32>> {
        self.now += CYCLE;
        let event = SyncEvent {
            at: Instant::from_ticks(self.now),
            is_sync: true,
            position,
            velocity: None,
            torque: None,
        };
        let mut slots = Slots::new();
        let times = (self.interpolation << POINT, 0);
        self.clock
            .on_sync_event(event, position.is_some(), times, &mut slots);
        assert!(slots.len() <= 1);
        let slot = slots.first()?;
        Some(slot.event.and_then(|event| event.position))
    }

    /// Set-points, each this many SYNCs after the one before; returns what is in the slots, each with the SYNCs since the slot before.
    fn set_points(&mut self, apart: impl IntoIterator<Item = u32>) -> Vec<(u32, Option<i32>)> {
        let mut slots = Vec::new();
        let mut since = 0;
        for (position, apart) in (1..).zip(apart) {
            for left in (0..apart).rev() {
                since += 1;
                if let Some(slot) = self.sync((left == 0).then_some(position)) {
                    slots.push((since, slot));
                    since = 0;
                }
            }
        }
        slots
    }

    /// Locked, with four SYNCs for one set-point.
    fn locked() -> Self {
        let mut network = Self::new(4 * CYCLE);
        network.set_points([4; 30]);
        assert!(network.clock.pll().is_locked());
        network
    }
}

#[test]
fn m64_a_set_point_one_sync_late_waits_for_its_slot_and_the_next_is_in_time() {
    let slots = Network::locked().set_points([4, 5, 3, 4, 4]);
    let expected = [Some(1), None, Some(3), Some(4), Some(5)];
    assert_eq!(slots, expected.map(|position| (4, position)));
}

#[test]
fn m65_a_set_point_one_sync_early_waits_for_its_slot() {
    let slots = Network::locked().set_points([4, 3, 5, 4, 4]);
    let expected = [1, 2, 3, 4, 5].map(|position| (4, Some(position)));
    assert_eq!(slots, expected);
}

#[test]
fn m67_set_points_that_stay_a_sync_late_keep_the_slots() {
    let slots = Network::locked().set_points([4, 5].into_iter().chain([4; 100]));
    assert!(slots.iter().all(|(since, _)| *since == 4));
    assert_eq!(slots.iter().filter(|(_, slot)| slot.is_none()).count(), 1);
}

#[test]
fn m67_set_points_that_come_more_often_count_as_they_come_and_less_often_again() {
    let mut network = Network::locked();
    let slots = network.set_points([2; 40]);
    assert!(slots[20..].iter().all(|slot| slot.0 == 2));
    let slots = network.set_points([4; 40]);
    assert!(
        slots[30..]
            .iter()
            .all(|slot| slot.0 == 4 && slot.1.is_some())
    );
}

#[test]
fn m67_60c2h_that_changes_while_sync_comes_counts() {
    let mut network = Network::new(CYCLE);
    network.set_points([1; 100]);
    network.interpolation = 4 * CYCLE;
    let slots = network.set_points([4; 20]);
    assert!(
        slots[1..]
            .iter()
            .all(|slot| slot.0 == 4 && slot.1.is_some())
    );
}

#[test]
fn after_a_pause_the_slots_begin_at_the_first_set_point() {
    let mut network = Network::locked();
    network.set_points([101]);
    let slots = network.set_points([4; 10]);
    assert!(slots.iter().all(|slot| slot.0 == 4 && slot.1.is_some()));
}
