//! What the pages PDOs, Scope and Objects order: a table that is applied as a whole or not at all, recordings, live values, files.

use sim::products::{Drive, Product};

use super::*;
use crate::message::{Difference, Mapped, Pdo, PdoTable, Recorded, Recorder, Wish};

impl Bench {
    fn table(&mut self) -> PdoTable {
        match self.order(Order::Pdos { node: NODE }) {
            Outcome::Done(Answer::Pdos(table)) => table,
            other => panic!("{other:?}"),
        }
    }

    pub(super) fn file(&mut self) -> (String, String) {
        match self.order(Order::Dump { node: NODE }) {
            Outcome::Done(Answer::File { name, text }) => (name, text),
            other => panic!("{other:?}"),
        }
    }

    pub(super) fn differences(&mut self, (name, text): &(String, String)) -> Vec<Difference> {
        let (name, text) = (name.clone(), text.clone());
        match self.order(Order::Compare {
            node: NODE,
            name,
            text,
        }) {
            Outcome::Done(Answer::Differences(found)) => found,
            other => panic!("{other:?}"),
        }
    }
}

/// A drive whose type is known at run time only.
#[derive(Debug)]
struct Boxed(Box<dyn Drive>);

impl Station for Boxed {
    fn receive(&mut self, frame: &Frame, now: Instant) {
        self.0.receive(frame, now);
    }

    fn poll(&mut self, now: Instant) -> Instant {
        self.0.poll(now)
    }

    fn transmit(&mut self) -> Option<Frame> {
        self.0.transmit()
    }
}

fn mapped(object: &str, bits: u8) -> Mapped {
    Mapped {
        object: object.to_owned(),
        bits,
    }
}

fn tpdo(table: &mut PdoTable, number: u16) -> &mut Pdo {
    let mut pdos = table.pdos.iter_mut();
    pdos.find(|pdo| !pdo.receive && pdo.number == number)
        .unwrap()
}

#[test]
fn a_table_of_pdos_is_applied() {
    let mut bench = Bench::chosen();
    let mut table = bench.table();
    assert_eq!(table.pdos.len(), 8);
    assert!(
        table
            .mappable
            .iter()
            .any(|one| one.object == "6064h:00" && one.transmit && one.bits == 32)
    );
    let fourth = tpdo(&mut table, 4);
    fourth.enabled = true;
    fourth.kind = 255;
    fourth.event_timer = Some(5);
    fourth.mapped = vec![mapped("6064h:00", 32), mapped("606Ch:00", 32)];
    bench.bus().take_trace();
    bench.done(Order::SetPdos {
        node: NODE,
        pdos: table.pdos.clone(),
    });
    // Off, unmapped, mapped, on: the COB-ID comes first and last.
    let written: Vec<(u16, u8)> = (bench.bus().trace().iter())
        .filter(|logged| logged.sender == PANEL)
        .filter_map(|logged| match logged.frame.payload() {
            [command, low, high, sub, ..] if command >> 5 == 1 => {
                Some((u16::from_le_bytes([*low, *high]), *sub))
            }
            _ => None,
        })
        .collect();
    assert_eq!(written.first(), Some(&(0x1803, 1)));
    assert_eq!(written[1], (0x1A03, 0));
    assert_eq!(written.last(), Some(&(0x1803, 1)));
    assert!(
        written
            .iter()
            .all(|(index, _)| matches!(index, 0x1803 | 0x1A03)),
        "{written:04X?}"
    );
    assert_eq!(bench.table().pdos, table.pdos);
}

#[test]
fn a_table_that_is_refused_leaves_all_as_it_was() {
    let mut bench = Bench::chosen();
    let before = bench.table();
    let mut table = before.clone();
    // Fine.
    tpdo(&mut table, 1).mapped = vec![mapped("6064h:00", 32)];
    // The drive knows no identifiers of 29 bits; the panel does not know that of every drive.
    tpdo(&mut table, 2).cob_id = 0x1_2345;
    let why = bench.refused(Order::SetPdos {
        node: NODE,
        pdos: table.pdos,
    });
    assert!(why.starts_with("node 4 refuses 1801h:01"), "{why}");
    assert!(why.ends_with("all PDOs are as they were"), "{why}");
    assert_eq!(bench.table().pdos, before.pdos);
    // What cannot be is not even begun.
    let mut wrong = before;
    tpdo(&mut wrong, 1).mapped = vec![mapped("6064h:00", 32); 3];
    bench.bus().take_trace();
    let why = bench.refused(Order::SetPdos {
        node: NODE,
        pdos: wrong.pdos,
    });
    assert_eq!(why, "TPDO 1: 96 bits are mapped, a frame has 64");
    assert!(
        !bench
            .bus()
            .trace()
            .iter()
            .any(|logged| logged.sender == PANEL)
    );
}

fn wish(trigger: &str) -> Wish {
    Wish {
        channels: vec!["6064".to_owned(), "606C".to_owned()],
        trigger: trigger.to_owned(),
        divider: Some(1),
        samples: Some(500),
        before: Some(20),
    }
}

#[test]
fn a_recording_waits_for_its_trigger_while_the_drive_is_moved() {
    let mut bench = Bench::enabled();
    bench.done(Order::Record(wish("606C>1000")));
    bench.run_for(500);
    assert_eq!(bench.session.state().recorder, Some(Recorder::Armed));
    bench.done(go(2_000, Some(5_000)));
    bench.run_for(2_000);
    assert_eq!(
        (
            bench.session.state().recorder,
            bench.session.state().recordings
        ),
        (None, 1)
    );
    let Outcome::Done(Answer::Recording(recorded)) = bench.order(Order::Recording) else {
        panic!("no recording");
    };
    let Recorded { number: 1, report } = *recorded else {
        panic!("{recorded:?}");
    };
    let told = serde_json::to_value(report).unwrap();
    assert_eq!(
        (told["samples"].as_u64(), told["trigger_index"].as_u64()),
        (Some(500), Some(100))
    );
    let velocity = told["channels"][1]["values"].as_array().unwrap();
    assert!(velocity[99].as_i64().unwrap() < 1_000 && velocity[100].as_i64().unwrap() >= 1_000);
    // One that nobody wants any more.
    bench.done(Order::Record(wish("fault")));
    bench.done(Order::StopRecorder);
    bench.run_for(200);
    assert_eq!(
        (
            bench.session.state().recorder,
            bench.session.state().recordings
        ),
        (None, 1)
    );
    let why = bench.refused(Order::Record(wish("6064>fast")));
    assert!(
        why.starts_with("`fast` in `6064>fast` is no level"),
        "{why}"
    );
}

#[test]
fn eight_channels_come_live_at_1_khz_and_what_nobody_reads_is_bounded() {
    let mut bench = Bench::enabled();
    let mut table = bench.table();
    for pdo in table.pdos.iter_mut().filter(|pdo| !pdo.receive) {
        pdo.enabled = true;
        pdo.kind = 255;
        pdo.inhibit_time = Some(0);
        pdo.event_timer = Some(1);
        pdo.mapped = match pdo.number {
            1 => vec![
                mapped("6041h:00", 16),
                mapped("6061h:00", 8),
                mapped("603Fh:00", 16),
            ],
            2 => vec![mapped("6064h:00", 32), mapped("606Ch:00", 32)],
            3 => vec![mapped("6062h:00", 32), mapped("60F4h:00", 32)],
            _ => vec![mapped("60FDh:00", 32)],
        };
    }
    bench.done(Order::SetPdos {
        node: NODE,
        pdos: table.pdos,
    });
    let Outcome::Done(Answer::Channels(channels)) = bench.order(Order::Channels) else {
        panic!("no channels");
    };
    assert_eq!(channels.len(), 8);
    // Somebody who never reads, and somebody who does.
    let mut slow = bench.session.outlet.live.subscribe();
    let mut quick = bench.session.outlet.live.subscribe();
    let mut counts = [0; 8];
    // As long as anybody likes: `cargo xtask soak` takes an hour of it.
    let seconds = std::env::var("AXIS402_SOAK_LIVE").map_or(5, |text| text.parse().unwrap());
    for _ in 0..20 * seconds {
        bench.run_for(50);
        bench.bus().take_trace();
        while let Ok(text) = quick.try_recv() {
            let event: serde_json::Value = serde_json::from_str(&text).unwrap();
            assert_eq!(event["dropped"], 0);
            for one in event["values"].as_array().unwrap() {
                counts[one["channel"].as_u64().unwrap() as usize] +=
                    one["values"].as_array().unwrap().len();
            }
        }
    }
    // Each millisecond, the jitter of the first and the last one aside.
    let all = 1_000 * seconds;
    let whole = all - all / 50..=all + all / 50;
    assert!(
        counts.iter().all(|count| whole.contains(count)),
        "{counts:?}"
    );
    // Whoever is slow is told how much was missed, and the queue is as long as it was.
    use tokio::sync::broadcast::error::TryRecvError;
    assert!(matches!(slow.try_recv(), Err(TryRecvError::Lagged(missed)) if missed > 20));
    assert!(slow.len() <= BATCHES);
    // The drive is moved and stopped all the same.
    bench.done(go(1_000, None));
    bench.bus().take_trace();
    let at = bench.session.master_mut().now();
    bench.desk.stop();
    bench.run_for(200);
    let stopped = bench.written(0x6040, 0, 0x02).unwrap();
    assert!(stopped.checked_duration_since(at).unwrap() <= milliseconds(20));
}

#[test]
fn a_configuration_goes_out_and_comes_in_and_is_compared() {
    let mut bench = Bench::chosen();
    let file = bench.file();
    assert_eq!(file.0, "node-4.dcf");
    assert!(file.1.contains("[DeviceComissioning]") || file.1.contains("[DeviceCommissioning]"));
    assert_eq!(bench.differences(&file), []);
    bench.done(write("6083", "77777"));
    let found = bench.differences(&file);
    assert_eq!(found.len(), 1, "{found:?}");
    assert_eq!(
        (found[0].address.as_str(), found[0].name.as_str()),
        ("6083h:00", "Profile acceleration")
    );
    assert!(found[0].here.contains("77777"), "{found:?}");
    let (name, text) = file.clone();
    let said = bench.done(Order::Load {
        node: NODE,
        name,
        text,
    });
    assert!(said.starts_with("1 values written"), "{said}");
    assert_eq!(bench.differences(&file), []);
    let sheet = Order::Load {
        node: NODE,
        name: "drive.eds".to_owned(),
        text: "[FileInfo]\n".to_owned(),
    };
    assert_eq!(
        bench.refused(sheet),
        "drive.eds is no DCF: it configures nothing"
    );
    assert_eq!(
        bench.done(Order::Save { node: NODE }),
        "node 4 has saved its parameters"
    );
    let said = bench.done(Order::Restore { node: NODE });
    assert_eq!(
        said,
        "node 4 has the factory's parameters after its next reset"
    );
}

#[test]
fn a_data_sheet_that_a_person_chooses_is_used() {
    let mut bench = Bench::chosen();
    let sheet = |name: &str, text: &str| Order::Sheet {
        node: NODE,
        name: name.to_owned(),
        text: text.to_owned(),
    };
    let why = bench.refused(sheet("letter.txt", "Dear drive,"));
    assert_eq!(why, "letter.txt is no data sheet: no objects in it");
    let eds = include_str!("../../../../eds/axis402.eds");
    assert_eq!(bench.done(sheet("a.eds", eds)), "node 4 is read by a.eds");
    let Outcome::Done(Answer::Dictionary { title, .. }) =
        bench.order(Order::Dictionary { node: NODE })
    else {
        panic!("no dictionary");
    };
    assert_eq!(title, "a.eds");
    let other = eds
        .replacen("ProductNumber=0x00000402", "ProductNumber=0x00000999", 1)
        .replacen("[6081]\n", "[6081]\nObjectType=nonsense\n", 1);
    let said = bench.done(sheet("b.eds", &other));
    assert_eq!(
        said,
        "node 4 is read by b.eds; it has mistakes, the rest is used; by its vendor-ID and product code it is of another device"
    );
    bench.run_for(100);
    assert!(bench.drive().answers);
}

#[test]
fn what_can_be_recorded_is_told_by_the_data_sheet() {
    let mut bench = Bench::chosen();
    let recordable = |bench: &mut Bench| match bench.order(Order::Recordable) {
        Outcome::Done(Answer::Recordable(all)) => all,
        other => panic!("{other:?}"),
    };
    let all = recordable(&mut bench);
    let usual = all.iter().filter(|one| one.is_usual);
    let usual: Vec<_> = usual.map(|one| one.object.as_str()).collect();
    assert!(
        usual.contains(&"606Ch:00") && usual.len() < all.len(),
        "{usual:?}"
    );
    bench.run_for(100);
    assert!(bench.drive().has_recorder);
    assert_eq!(all.len(), 17);
    for some in all.chunks(8) {
        bench.done(Order::Record(Wish {
            channels: some.iter().map(|one| one.object.clone()).collect(),
            samples: Some(10),
            before: None,
            ..wish("now")
        }));
        bench.run_for(500);
    }
    assert_eq!(bench.session.state().recordings, 3);
    // Another maker's drive has none.
    let eds = include_str!("../../../../products/lmd/lmd.eds");
    bench.done(Order::Sheet {
        node: NODE,
        name: "lmd.eds".to_owned(),
        text: eds.to_owned(),
    });
    assert_eq!(recordable(&mut bench), []);
    bench.run_for(100);
    assert!(!bench.drive().has_recorder);
}

#[test]
fn drives_of_two_makers_are_shown_each_by_its_own_words() {
    let (mut bench, _) = Bench::with(DriveSetup::with_node_id(1, NODE), false);
    let product = Product::named("lmd").unwrap();
    let other = product.drive(DriveSetup::with_node_id(2, 5));
    bench.session.setup.sheets.push(product.data_sheet());
    bench.bus().attach(Boxed(other));
    bench.run_for(100);
    assert_eq!(bench.done(Order::Scan), "2 nodes");
    for (id, title) in [(NODE, "axis402.eds"), (5, "lmd.eds")] {
        bench.done(Order::Choose { node: id });
        bench.run_for(300);
        assert_eq!((bench.drive().node, bench.drive().answers), (id, true));
        assert!(bench.drive().state.is_some());
        let Outcome::Done(Answer::Dictionary { title: told, .. }) =
            bench.order(Order::Dictionary { node: id })
        else {
            panic!("no dictionary");
        };
        assert_eq!(told, title);
    }
}
