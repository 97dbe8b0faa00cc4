//! `sim scope`, and the block upload of the master below it.

use std::cell::Cell;
use std::rc::Rc;

use canopen::Duration;
use master::Failure;
use master::bus::simulated::{Handle, Interference};
use master::scope::{Before, Edge, Recording, Request, Trigger, record};
use sim::Axis402;

use crate::bench::{Bench, refusal};

const STATUSWORD: u32 = 0x6041_0010;
const POSITION: u32 = 0x6064_0020;
const VELOCITY: u32 = 0x606C_0020;

/// A drive in operation enabled, in profile position.
fn enabled() -> (Bench, Handle<Axis402>) {
    let (mut bench, drives) = Bench::with_drives(&[4]);
    for controlword in [0x06_u16, 0x07, 0x0F] {
        bench.master.write(4, 0x6040, 0, controlword).unwrap();
        bench.master.run_for(Duration::from_ticks(5_000));
    }
    (bench, drives[0])
}

/// Begins a move by so many steps.
fn begin_move(bench: &mut Bench, steps: i32) {
    bench.master.write(4, 0x607A, 0, steps).unwrap();
    bench.master.write(4, 0x6040, 0, 0x5F_u16).unwrap();
}

fn request(trigger: Trigger) -> Request {
    Request {
        channels: Some(vec![STATUSWORD, POSITION, VELOCITY]),
        divider: Some(1),
        samples: Some(200),
        before: Some(Before::Percent(25)),
        trigger,
        patience: Duration::from_ticks(2_000_000),
    }
}

fn values(recording: &Recording, channel: usize) -> &[i64] {
    &recording.channels[channel].values
}

#[test]
fn a_move_is_recorded_from_before_its_trigger() {
    let (mut bench, _) = enabled();
    let node = bench.meet(4);
    bench.master.write(4, 0x6083, 0, 20_000_u32).unwrap();
    begin_move(&mut bench, 20_000);
    let trigger = Trigger::parse("velocity actual value>5000", &node.sheet).unwrap();
    let request = request(trigger);
    let mut recording = None;
    let told = bench.run(|master, console| {
        recording = Some(record(master, &node, &request, console)?);
        Ok(())
    });
    told.unwrap();
    assert_eq!(
        bench.progress,
        "node 4: the scope is armed and waits for its trigger\n"
    );
    let recording = recording.unwrap();
    assert_eq!((recording.count(), recording.before), (200, 50));
    assert_eq!(
        (recording.tick_ns, recording.divider, recording.late),
        (1_000_000, 1, 0)
    );
    assert_eq!(
        recording.channels[1].title,
        "6064h:00 Position actual value"
    );
    let velocity = values(&recording, 2);
    assert!(
        velocity[49] < 5_000 && velocity[50] >= 5_000,
        "{velocity:?}"
    );
    let position = values(&recording, 1);
    assert!(
        position.is_sorted() && position[0] < position[199],
        "{position:?}"
    );
    assert!((recording.time(0) + 0.050).abs() < 1e-9);
    assert!((recording.time(199) - 0.149).abs() < 1e-9);
}

#[test]
fn without_a_trigger_it_begins_at_once() {
    let (mut bench, _) = Bench::with_drives(&[4]);
    let node = bench.meet(4);
    let request = Request {
        channels: None,
        ..request(Trigger::Now)
    };
    let recording = bench
        .run(|master, console| record(master, &node, &request, console))
        .unwrap();
    assert_eq!((recording.count(), recording.before), (200, 50));
    let titles: Vec<_> = recording
        .channels
        .iter()
        .map(|channel| channel.address.to_string())
        .collect();
    assert_eq!(
        titles,
        ["6041h:00", "6062h:00", "6064h:00", "606Ch:00"],
        "as the data sheet has them"
    );
    assert!(
        values(&recording, 0)
            .iter()
            .all(|statusword| *statusword == 0x0250)
    );
}

#[test]
fn what_the_line_loses_comes_again() {
    for every in [3_u32, 13, 47] {
        let (mut bench, _) = Bench::with_drives(&[4]);
        let node = bench.meet(4);
        let request = Request {
            samples: Some(400),
            before: None,
            ..request(Trigger::Now)
        };
        let recording = bench
            .run(|master, console| record(master, &node, &request, console))
            .unwrap();
        let data = bench.master.read::<Vec<u8>>(4, 0x20D3, 0).unwrap();
        assert_eq!(Recording::read(&data, &node.sheet), Ok(recording));
        let (mut state, lost) = (every, Rc::new(Cell::new(0)));
        let losing = Rc::clone(&lost);
        bench.master.bus_mut().interfere(move |logged| {
            // Segments alone; the rest is for the caller to repeat.
            let is_segment = logged.frame.standard_id() == Some(0x584)
                && !matches!(logged.frame.payload(), [0xC0..=0xDF | 0x80, ..]);
            // Numerical Recipes' generator: losses in step with the blocks would never end.
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            if is_segment && (state >> 16) % every == 0 {
                losing.set(losing.get() + 1);
                Interference::Lose
            } else {
                Interference::None
            }
        });
        let read = bench.master.read_by_blocks(4, 0x20D3, 0);
        assert!(read == Ok(data), "every {every}: {:?}", read.err());
        assert!(lost.get() > 10, "{}", lost.get());
    }
}

#[test]
fn a_block_upload_of_any_object_is_what_segments_are() {
    let (mut bench, _) = Bench::with_drives(&[4]);
    for (index, sub) in [
        (0x1000, 0),
        (0x1008, 0),
        (0x1018, 4),
        (0x6041, 0),
        (0x6040, 0),
    ] {
        let value = bench.master.read::<Vec<u8>>(4, index, sub).unwrap();
        assert_eq!(
            bench.master.read_by_blocks(4, index, sub),
            Ok(value),
            "{index:04X}h"
        );
    }
    // Nothing is recorded, and no byte is a value too.
    assert_eq!(bench.master.read_by_blocks(4, 0x20D3, 0), Ok(Vec::new()));
    assert_eq!(
        bench.master.read_by_blocks(4, 0x2FFF, 0),
        Err(Failure::Abort {
            index: 0x2FFF,
            sub: 0,
            code: 0x0602_0000,
        })
    );
    let silent = bench.master.read_by_blocks(5, 0x1000, 0);
    assert!(matches!(silent, Err(Failure::Timeout { .. })), "{silent:?}");
}

#[test]
fn what_cannot_be_is_told_in_words() {
    let (mut bench, _) = Bench::with_drives(&[4]);
    let node = bench.meet(4);
    let mut refused = |request: Request| {
        refusal(bench.run(|master, console| record(master, &node, &request, console)))
    };
    let unheard = Trigger::Edge {
        object: VELOCITY,
        edge: Edge::Rising,
        level: 1,
        mask: 0,
    };
    assert_eq!(
        refused(request(unheard)),
        ("node 4: the trigger has not come within 2 s".to_owned(), 1)
    );
    let (line, code) = refused(Request {
        channels: Some(vec![0x1018_0420]),
        ..request(Trigger::Now)
    });
    assert_eq!(code, 1);
    assert!(
        line.starts_with("node 4 refuses 20D1h:01 with 06040041h"),
        "{line}"
    );
    // 20,480 bytes; 10 bytes a sample are three words.
    let usage = |line: &str| (line.to_owned(), 2);
    assert_eq!(
        refused(Request {
            samples: Some(60_000),
            ..request(Trigger::Now)
        }),
        usage("60000 samples are too many: 1706 samples of these channels fit")
    );
    assert_eq!(
        refused(Request {
            before: Some(Before::Samples(200)),
            ..request(Trigger::Now)
        }),
        usage(
            "200 samples older than the trigger are too many: --pre must be below the samples, which are 200"
        )
    );
    assert_eq!(
        refused(Request {
            samples: Some(0),
            before: Some(Before::Samples(1_706)),
            ..request(Trigger::Now)
        }),
        usage(
            "1706 samples older than the trigger are too many: --pre must be below the samples, which are 1706"
        )
    );
    assert_eq!(
        refused(Request {
            channels: Some(Vec::new()),
            ..request(Trigger::Now)
        }),
        usage("no channel records anything: name up to eight objects with --channels")
    );
    let just = Request {
        samples: Some(1_706),
        before: Some(Before::Samples(1_705)),
        ..request(Trigger::Now)
    };
    let recording = bench.run(|master, console| record(master, &node, &just, console));
    assert_eq!(recording.unwrap().count(), 1_706);
    // The recorder was stopped: it can be set up again.
    let mut all = request(Trigger::Now);
    all.before = Some(Before::Samples(3));
    let recording = bench.run(|master, console| record(master, &node, &all, console));
    assert_eq!(recording.unwrap().before, 3);
}

#[test]
fn triggers_are_read_as_a_person_writes_them() {
    let (mut bench, _) = Bench::with_drives(&[4]);
    let sheet = bench.meet(4).sheet;
    let edge = |object, edge, level, mask| Trigger::Edge {
        object,
        edge,
        level,
        mask,
    };
    for (text, trigger) in [
        ("now", Trigger::Now),
        ("drive", Trigger::AsSetUp),
        ("fault", edge(STATUSWORD, Edge::Rising, 0, 8)),
        ("606C>-20", edge(VELOCITY, Edge::Rising, -20, 0)),
        ("606Ch < 20", edge(VELOCITY, Edge::Falling, 20, 0)),
        (
            "position actual value~0",
            edge(POSITION, Edge::Either, 0, 0),
        ),
        ("6041#10", edge(STATUSWORD, Edge::Rising, 0, 0x400)),
        ("6041#10=0", edge(STATUSWORD, Edge::Falling, 0, 0x400)),
    ] {
        assert_eq!(Trigger::parse(text, &sheet), Ok(trigger), "{text}");
    }
    for text in [
        "",
        "6041",
        "606C>fast",
        "6041#32",
        "6041#16",
        "6061#8",
        "6041#1=2",
        "6041>65536",
        "6041<0",
        "6061~-128",
        "flux>1",
        "1008>1",
    ] {
        assert!(Trigger::parse(text, &sheet).is_err(), "{text}");
    }
    assert_eq!(
        Trigger::parse("6064>abc", &sheet).unwrap_err(),
        "`abc` in `6064>abc` is no level: a whole number, -2147483648 to 2147483647"
    );
}

#[test]
fn bytes_that_are_no_recording_are_refused() {
    let (mut bench, _) = Bench::with_drives(&[4]);
    let sheet = bench.meet(4).sheet;
    let recording = bench
        .run(|master, console| {
            let node = master::axis402::Node {
                id: 4,
                sheet: std::sync::Arc::clone(&sheet),
            };
            record(master, &node, &request(Trigger::Now), console)
        })
        .unwrap();
    let data = bench.master.read::<Vec<u8>>(4, 0x20D3, 0).unwrap();
    assert_eq!(Recording::read(&data, &sheet), Ok(recording));
    for length in 0..data.len() {
        assert!(
            Recording::read(&data[..length], &sheet).is_err(),
            "{length}"
        );
    }
    let mut newer = data;
    newer[0] = 2;
    let why = Recording::read(&newer, &sheet).unwrap_err();
    assert_eq!(why, "the recording has format 2; this program reads 1");
}
