//! Devices with the data sheets of other vendors: the tool knows a device by its data sheet only.

use std::path::Path;
use std::sync::Arc;

use canopen::cia301::nmt::Reset;
use canopen::od::Dictionary;
use canopen::{BitRate, Duration, Event, Frame, Instant, NodeId, Settings};
use master::axis402::{Node, dump, load, read, scan, write};
use master::bus::Station;
use master::data_sheet::DataSheet;
use products::{lmd, nanotec, s200, tc1};

use crate::bench::Bench;

/// A device that has its objects and no application.
#[derive(Debug)]
struct Device<D: Dictionary>(canopen::Node<D>);

impl<D: Dictionary> Device<D> {
    fn new(dictionary: D) -> Self {
        let settings = Settings {
            node_id: NodeId::new(9).unwrap(),
            bit_rate: BitRate::Kbit1000,
        };
        let mut node = canopen::Node::new(dictionary, settings);
        node.boot(Reset::Node, Instant::from_ticks(0), &mut ());
        Self(node)
    }
}

impl<D: Dictionary + std::fmt::Debug + 'static> Station for Device<D> {
    fn receive(&mut self, frame: &Frame, now: Instant) {
        self.0.receive(frame, now, &mut ());
    }

    fn poll(&mut self, now: Instant) -> Instant {
        while let Some(event) = self.0.event() {
            if let Event::ResetRequested(reset) = event {
                self.0.boot(reset, now, &mut ());
            }
        }
        self.0.poll(now, &mut ())
    }

    fn transmit(&mut self) -> Option<Frame> {
        self.0.transmit(&mut ())
    }
}

fn sheet(name: &str) -> Arc<DataSheet> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../products")
        .join(name)
        .join(name)
        .with_extension("eds");
    Arc::new(od_gen::read(&path).unwrap().into())
}

fn bench_with<D: Dictionary + std::fmt::Debug + 'static>(dictionary: D) -> Bench {
    let mut bench = Bench::new();
    bench.attach(Device::new(dictionary));
    bench.master.run_for(Duration::from_ticks(10_000));
    bench
}

/// Reads everything, and writes the configuration back.
fn is_dumped_and_loaded<D: Dictionary + std::fmt::Debug + 'static>(dictionary: D, name: &str) {
    let mut bench = bench_with(dictionary);
    assert!(bench.told(scan).ends_with("1 node\n"), "{}", bench.output);
    let node = Node::meet(&mut bench.master, 9, Some(sheet(name))).unwrap();
    let model = bench
        .run(|master, console| dump(master, &node, true, console))
        .unwrap();
    let read = bench.output.lines().count();
    assert!(read > 100, "{name}: {read} values");
    let configured = model
        .entries()
        .filter(|(_, entry)| entry.configured.is_some());
    let count = configured.count();
    assert!(count > 30, "{name}: {count} values are a configuration");
    let told = bench.told(|master, console| load(master, &node, &model, console));
    assert_eq!(
        told,
        format!("0 values written, {count} were so already\n"),
        "{name}"
    );
}

#[test]
fn a_lexium_mdrive_is_dumped_and_loaded() {
    is_dumped_and_loaded(lmd::Dictionary::new(), "lmd");
}

#[test]
fn a_nanotec_drive_is_dumped_and_loaded() {
    is_dumped_and_loaded(nanotec::Dictionary::new(), "nanotec");
}

#[test]
fn an_s200_is_dumped_and_loaded() {
    is_dumped_and_loaded(s200::Dictionary::new(), "s200");
}

#[test]
fn a_tc1_is_dumped_and_loaded() {
    is_dumped_and_loaded(tc1::Dictionary::new(), "tc1");
}

#[test]
fn a_stranger_has_the_objects_of_the_standards_and_the_rest_by_number() {
    let mut bench = bench_with(lmd::Dictionary::new());
    let node = bench.meet(9);
    let wanted = ["vendor-ID".to_owned()];
    let told = bench.told(|master, console| read(master, &node, &wanted, None, false, console));
    assert_eq!(told, "1018h:01 Identity object: Vendor-ID: 539\n");

    // With its data sheet the objects of its manufacturer have names and types too.
    let sheet = sheet("lmd");
    let (object, entry) = (sheet.model().entries())
        .find(|(object, entry)| {
            (0x2000..=0x5FFF).contains(&object.index)
                && entry.access.is_writable()
                && entry.access.is_readable()
                && entry.data_type.range().is_some()
        })
        .unwrap();
    let place = format!("{:04X}:{:X}", object.index, entry.sub);
    let refused = write(&mut bench.master, &node, &place, "1", None).unwrap_err();
    assert!(
        refused.line().unwrap().contains("the type of"),
        "{refused:?}"
    );
    let known = Node {
        id: 9,
        sheet: Arc::clone(&sheet),
    };
    write(&mut bench.master, &known, &place, "1", None).unwrap();
    let wanted = [place];
    let told = bench.told(|master, console| read(master, &known, &wanted, None, true, console));
    assert_eq!(told, "1\n");
}
