//! Every transfer ends, with the right data or with an abort, whatever the bus does to its frames (B29).

use std::vec::Vec;

use proptest::prelude::*;
use proptest::test_runner::contextualize_config;

use super::client::{Client, Outcome, Task};
use super::line::{Chance, Conditions, Line};
use super::store::Store;
use super::{STREAM, STRING, TestServer, server};
use crate::cia301::sdo::server::Step;
use crate::time::{Duration, Instant};

/// No transfer takes longer, in milliseconds.
const END: u64 = 120_000;

/// The server and what is around it.
struct Bus {
    server: TestServer,
    store: Store,
    chance: Chance,
    to_server: Line,
    to_client: Line,
    now: u64,
}

impl Bus {
    fn new(store: Store, seed: u64) -> Self {
        Self {
            server: server(),
            store,
            chance: Chance::new(seed),
            to_server: Line::default(),
            to_client: Line::default(),
            now: 0,
        }
    }

    /// A millisecond.
    fn step(&mut self, client: &mut Client, conditions: &Conditions) {
        self.now += 1;
        let now = Instant::from_ticks(0) + Duration::from_ticks(self.now * 1000);
        while let Some(frame) = self.to_server.receive(self.now) {
            if self.server.answers.is_full() {
                self.server.receive_abort(&frame, &mut self.store);
            } else {
                self.server.receive(&frame, now, &mut self.store);
            }
        }
        self.server.poll(now, &mut self.store);
        // Now and then the bus is busy.
        if self.chance.below(4) > 0
            && let Some(frame) = self.server.transmit(&mut self.store)
        {
            self.to_client
                .send(frame, self.now, conditions, &mut self.chance);
        }
        while let Some(frame) = self.to_client.receive(self.now) {
            client.receive(&frame, self.now);
        }
        client.poll(self.now);
        if let Some(frame) = client.transmit() {
            self.to_server
                .send(frame, self.now, conditions, &mut self.chance);
        }
    }

    /// A whole transfer. The client may give up at some time.
    fn transfer(&mut self, task: Task, conditions: &Conditions, aborts_at: Option<u64>) -> Outcome {
        let begin = self.now;
        let mut client = Client::new(task, begin);
        while client.outcome().is_none() {
            if aborts_at == Some(self.now - begin) {
                client.abort();
            }
            self.step(&mut client, conditions);
            assert!(self.now - begin < END, "the client hangs: {client:?}");
        }
        let outcome = client.outcome().cloned().unwrap();
        // The server learns of the end, or loses its patience.
        for _ in 0..4000 {
            self.step(&mut client, &Conditions::GOOD);
        }
        assert_eq!(self.server.step, Step::Idle, "the server hangs");
        assert!(self.store.incoming.is_none(), "the application waits");
        outcome
    }
}

fn task(value: bool) -> impl Strategy<Value = Task> {
    (
        any::<bool>(),
        any::<bool>(),
        any::<bool>(),
        prop::collection::vec(1..=127_u8, 1..6),
        prop::collection::vec(any::<u8>(), 0..=2000),
    )
        .prop_map(
            move |(is_stream, is_block, tells_size, block_sizes, data)| Task {
                object: if is_stream { STREAM } else { STRING },
                is_block,
                has_crc: true,
                tells_size,
                block_sizes,
                value: value.then_some(data),
            },
        )
}

fn conditions() -> impl Strategy<Value = Conditions> {
    (0..60_u64, 0..60_u64, 0..40_u64, 1..1200_u64).prop_map(|(lost, doubled, delayed, delay)| {
        Conditions {
            lost,
            doubled,
            delayed,
            delay,
        }
    })
}

/// A transfer that must not fail.
fn undisturbed(bus: &mut Bus, object: &Task, value: Option<Vec<u8>>) -> Vec<u8> {
    let task = Task {
        value,
        ..object.clone()
    };
    bus.transfer(task, &Conditions::GOOD, None)
        .expect("nothing disturbs")
}

proptest! {
    #![proptest_config(contextualize_config(ProptestConfig::with_cases(300)))]

    #[test]
    fn b29_what_is_written_is_read(
        mut task in task(true), has_crc: bool, hides_size: bool, seed: u64,
    ) {
        task.has_crc = has_crc;
        let store = Store { hides_size, ..Store::default() };
        let mut bus = Bus::new(store, seed);
        let value = task.value.clone();
        undisturbed(&mut bus, &task, value.clone());
        prop_assert_eq!(Some(&bus.store.value), value.as_ref());
        prop_assert_eq!(Some(undisturbed(&mut bus, &task, None)), value);
    }

    #[test]
    fn b29_a_download_over_a_bad_bus(
        task in task(true), conditions in conditions(), seed: u64,
        aborts_at in prop::option::weighted(0.2, 1..400_u64), old in prop::collection::vec(any::<u8>(), 0..50),
    ) {
        let store = Store { value: old.clone(), ..Store::default() };
        let mut bus = Bus::new(store, seed);
        let new = task.value.clone().unwrap();
        let outcome = bus.transfer(task.clone(), &conditions, aborts_at);
        // All or nothing; and what the client believes is true.
        if outcome.is_ok() {
            prop_assert_eq!(&bus.store.value, &new);
        } else {
            prop_assert!(bus.store.value == new || bus.store.value == old);
        }
        // The next one is served.
        undisturbed(&mut bus, &task, Some(new.clone()));
        prop_assert_eq!(&bus.store.value, &new);
    }

    #[test]
    fn b29_an_upload_over_a_bad_bus(
        task in task(false), conditions in conditions(), seed: u64, hides_size: bool,
        aborts_at in prop::option::weighted(0.2, 1..400_u64), value in prop::collection::vec(any::<u8>(), 0..=2000),
    ) {
        let store = Store { value: value.clone(), hides_size, ..Store::default() };
        let mut bus = Bus::new(store, seed);
        if let Ok(read) = bus.transfer(task.clone(), &conditions, aborts_at) {
            prop_assert_eq!(&read, &value);
        }
        prop_assert_eq!(undisturbed(&mut bus, &task, None), value);
    }
}

/// The disturbances are not so bad that nothing else comes to its end.
#[test]
fn b29_lost_segments_are_recovered() {
    let conditions = Conditions {
        lost: 5,
        doubled: 5,
        ..Conditions::GOOD
    };
    let value: Vec<u8> = (0..2000_u32).map(|n| (n % 251) as u8).collect();
    let mut ended_well = 0;
    for seed in 1..=100 {
        let store = Store {
            value: value.clone(),
            ..Store::default()
        };
        let mut bus = Bus::new(store, seed);
        for new in [Some(value.clone()), None] {
            let task = Task {
                object: STREAM,
                is_block: true,
                has_crc: true,
                tells_size: true,
                block_sizes: std::vec![40],
                value: new,
            };
            ended_well += u32::from(bus.transfer(task, &conditions, None).is_ok());
        }
    }
    assert!(ended_well > 150, "only {ended_well} of 200");
}
/// The last segment of such a value has the command of an end frame, and is equal to it if all is zero.
#[test]
fn b01_a_last_segment_that_looks_like_the_end() {
    for length in (440..540).step_by(7).chain([455, 456, 483, 511]) {
        for byte in [0, 1] {
            let mut bus = Bus::new(Store::default(), 1);
            let task = Task {
                object: STREAM,
                is_block: true,
                has_crc: byte == 0,
                tells_size: false,
                block_sizes: std::vec![1],
                value: None,
            };
            let value = std::vec![byte; length];
            undisturbed(&mut bus, &task, Some(value.clone()));
            assert_eq!(bus.store.value, value);
        }
    }
}
