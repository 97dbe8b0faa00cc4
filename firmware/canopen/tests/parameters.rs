//! Store and restore parameters: 1010h, 1011h, 1020h, on a store in memory.

use crate::device::ram_store::RamStore;
use crate::device::{Device, Objects, abort};
use canopen::Node;
use canopen::cia301::nmt::Reset;
use canopen::cia301::sdo::AbortCode;

pub const SAVE_ALL: &str = "604: 23 10 10 01 73 61 76 65";
pub const SAVED_ALL: &str = "584: 60 10 10 01 00 00 00 00";
const LOAD_ALL: &str = "604: 23 11 10 01 6C 6F 61 64";
const LOADED_ALL: &str = "584: 60 11 10 01 00 00 00 00";

/// A device with a store.
pub struct Storing {
    pub device: Device,
    pub store: RamStore,
}

impl Storing {
    /// Node 4 in Pre-operational, its boot-up message gone.
    pub fn new(store: RamStore) -> Self {
        Self::with_node_id(4, store)
    }

    pub fn with_node_id(node_id: u8, store: RamStore) -> Self {
        let off = Device::off_with(node_id);
        let mut storing = Self {
            device: Device {
                node: off.node.with_parameter_store(),
                ..off
            },
            store,
        };
        storing.boot(Reset::Node);
        assert_eq!(
            storing.device.sent().remove(0),
            format!("{:03X} [1] 00", 0x700 + u16::from(node_id))
        );
        storing.device.events();
        storing
    }

    /// Node 4 just booted, with what it has to say.
    pub fn with_node_id_and_messages(store: RamStore) -> Self {
        Self::just_booted(Device::off(), store)
    }

    /// Just booted, with what it has to say.
    pub fn just_booted(off: Device, store: RamStore) -> Self {
        let mut storing = Self {
            device: Device {
                node: off.node.with_parameter_store(),
                ..off
            },
            store,
        };
        storing.boot(Reset::Node);
        storing.device.poll();
        storing
    }

    pub fn boot(&mut self, reset: Reset) {
        self.device.boot(reset);
        assert!(self.device.node.is_loading());
        assert_eq!(self.device.sent(), [""; 0]);
        let now = self.device.now;
        self.device
            .node
            .load_parameters(&mut self.store, now, &mut self.device.firmware);
    }

    /// Power off and on again.
    pub fn power_cycle(self) -> Self {
        Self::new(self.store)
    }

    pub fn step(&mut self) {
        let now = self.device.now;
        self.device.node.store_parameters(&mut self.store, now);
    }

    /// Sends a request, stores as long as there is something to store, and returns what was sent.
    pub fn ask(&mut self, text: &str) -> Vec<String> {
        self.device.send(text);
        while self.device.node.is_storing() {
            assert_eq!(
                self.device.sent(),
                [""; 0],
                "an answer before the data is safe"
            );
            self.step();
        }
        self.device.poll();
        self.device.sent()
    }

    pub fn value(&self, index: u16, sub: u8) -> Vec<u8> {
        self.device.value(index, sub)
    }

    /// Writes an object by SDO.
    pub fn write(&mut self, index: u16, sub: u8, bytes: &[u8]) {
        let mut request = vec![0x23 | (4 - bytes.len() as u8) << 2];
        request.extend_from_slice(&index.to_le_bytes());
        request.push(sub);
        request.extend_from_slice(bytes);
        request.resize(8, 0);
        let request: String = request.iter().map(|byte| format!("{byte:02X}")).collect();
        let answer = self.ask(&format!("604: {request}"));
        assert!(answer[0].starts_with("584: 60"), "{answer:?}");
    }
}

#[test]
fn r01_save_is_answered_when_the_data_is_safe() {
    let mut storing = Storing::new(RamStore::default());
    storing.write(0x1017, 0, &[0xE8, 0x03]);
    storing.write(0x2000, 0, &[1, 2, 3, 4]);
    storing.write(0x6081, 0, &[0x39, 0x30, 0, 0]);
    storing.device.sent();
    storing.write(0x1017, 0, &[0xE9, 0x03]);
    storing.device.sent();
    assert_eq!(storing.ask(SAVE_ALL), [SAVED_ALL]);
    let storing = storing.power_cycle();
    assert_eq!(storing.value(0x1017, 0), [0xE9, 0x03]);
    assert_eq!(storing.value(0x2000, 0), [1, 2, 3, 4]);
    assert_eq!(storing.value(0x6081, 0), [0x39, 0x30, 0, 0]);
}

#[test]
fn r01_what_was_not_saved_is_gone_after_the_reset() {
    let mut storing = Storing::new(RamStore::default());
    assert_eq!(storing.ask(SAVE_ALL), [SAVED_ALL]);
    storing.write(0x2000, 0, &[1, 2, 3, 4]);
    let storing = storing.power_cycle();
    assert_eq!(storing.value(0x2000, 0), [0x78, 0x56, 0x34, 0x12]);
}

#[test]
fn r01_each_sub_index_saves_its_own_parameters() {
    for (sub, saved) in [(2, 0x1017), (3, 0x6081), (4, 0x2000)] {
        let mut storing = Storing::new(RamStore::default());
        let objects: [(u16, &[u8]); 3] = [
            (0x1017, &[0x10, 0x27]),
            (0x2000, &[9, 9, 9, 9]),
            (0x6081, &[7, 0, 0, 0]),
        ];
        for (index, value) in objects {
            storing.write(index, 0, value);
        }
        storing.device.sent();
        let answer = storing.ask(&format!("604: 23 10 10 {sub:02} 73 61 76 65"));
        assert_eq!(answer, [format!("584: 60 10 10 {sub:02} 00 00 00 00")]);
        let storing = storing.power_cycle();
        for (index, value) in objects {
            assert_eq!(
                storing.value(index, 0) == value,
                index == saved,
                "{index:04X}h"
            );
        }
    }
}

#[test]
fn r01_a_store_that_fails_is_told() {
    let mut storing = Storing::new(RamStore::default());
    storing.store.is_broken = true;
    assert_eq!(storing.ask(SAVE_ALL), [abort(0x1010, 1, 0x0606_0000)]);
    storing.store.is_broken = false;
    assert_eq!(storing.ask(SAVE_ALL), [SAVED_ALL]);
}

#[test]
fn r02_a_wrong_signature_stores_nothing() {
    let mut storing = Storing::new(RamStore::default());
    for signature in ["6C6F6164", "65766173", "73617664", "00000000"] {
        let refused = abort(0x1010, 1, 0x0800_0020);
        assert_eq!(
            storing.ask(&format!("604: 23 10 10 01 {signature}")),
            [refused]
        );
    }
    assert_eq!(storing.store.writes, 0);
}

#[test]
fn r03_defaults_return_at_the_reset_and_not_before() {
    let mut storing = Storing::new(RamStore::default());
    storing.write(0x2000, 0, &[1, 2, 3, 4]);
    storing.ask(SAVE_ALL);
    assert_eq!(storing.ask(LOAD_ALL), [LOADED_ALL]);
    assert_eq!(storing.value(0x2000, 0), [1, 2, 3, 4]);
    storing.device.send("000 [2] 81 04");
    storing.boot(Reset::Node);
    assert_eq!(storing.value(0x2000, 0), [0x78, 0x56, 0x34, 0x12]);
    let storing = storing.power_cycle();
    assert_eq!(storing.value(0x2000, 0), [0x78, 0x56, 0x34, 0x12]);
}

#[test]
fn r03_a_reset_of_the_communication_loads_its_parameters_only() {
    let mut storing = Storing::new(RamStore::default());
    storing.write(0x1015, 0, &[5, 0]);
    storing.write(0x2000, 0, &[1, 2, 3, 4]);
    storing.ask(SAVE_ALL);
    storing.write(0x1015, 0, &[6, 0]);
    storing.write(0x2000, 0, &[4, 3, 2, 1]);
    storing.boot(Reset::Communication);
    assert_eq!(storing.value(0x1015, 0), [5, 0]);
    assert_eq!(storing.value(0x2000, 0), [4, 3, 2, 1]);
}

#[test]
fn r04_a_wrong_signature_restores_nothing() {
    let mut storing = Storing::new(RamStore::default());
    let refused = abort(0x1011, 2, 0x0800_0020);
    assert_eq!(storing.ask("604: 23 11 10 02 73 61 76 65"), [refused]);
    assert_eq!(storing.store.writes, 0);
}

#[test]
fn r05_the_capability_says_that_it_saves_on_command() {
    let mut storing = Storing::new(RamStore::default());
    for index in ["1010", "1110"] {
        for sub in 1..=4 {
            let answer = storing.ask(&format!("604: 40 {index} {sub:02} 00 00 00 00"));
            assert_eq!(
                answer,
                [crate::device::full(
                    "584",
                    &format!("43 {index} {sub:02} 01")
                )]
            );
        }
    }
    let mut without = Device::new();
    assert_eq!(
        without.ask("604: 40 10 10 01 00 00 00 00"),
        ["584: 43 10 10 01 00 00 00 00"]
    );
    assert_eq!(without.ask(SAVE_ALL), [abort(0x1010, 1, 0x0800_0020)]);
}

#[test]
fn the_firmware_can_refuse_and_then_nothing_has_changed() {
    let mut storing = Storing::new(RamStore::default());
    storing.device.send(SAVE_ALL);
    storing.step();
    storing.device.node.refuse_storing(AbortCode::DeviceState);
    assert_eq!(storing.device.sent(), [abort(0x1010, 1, 0x0800_0022)]);
    assert!(!storing.device.node.is_storing());
    assert!(storing.store.sets.iter().all(Vec::is_empty));
}

#[test]
fn r01_communication_goes_on_while_parameters_are_stored() {
    let mut storing = Storing::new(RamStore::default());
    storing.device.send("000 [2] 01 04");
    storing.device.sent();
    storing.device.send(SAVE_ALL);
    storing.step();
    assert!(storing.device.node.is_storing());
    storing.device.send("204: 05 00 00 00 06 00 00 00");
    storing.device.set_value(0x2005, 0, &[9, 0, 0, 0]);
    storing.device.poll();
    assert_eq!(storing.device.sent(), ["184: 09 00 00 00 00 00 00 00"]);
    assert_eq!(storing.value(0x2003, 0), [5, 0, 0, 0]);
    assert_eq!(
        storing.ask("705 [1] 05"),
        [SAVED_ALL],
        "when the data is safe"
    );
}

#[test]
fn a_reset_in_the_middle_of_a_save_leaves_the_old_set() {
    let mut storing = Storing::new(RamStore::default());
    storing.write(0x2000, 0, &[1, 2, 3, 4]);
    storing.ask(SAVE_ALL);
    storing.write(0x2000, 0, &[4, 3, 2, 1]);
    storing.device.send(SAVE_ALL);
    storing.step();
    storing.step();
    storing.boot(Reset::Node);
    assert!(!storing.device.node.is_storing());
    assert_eq!(storing.value(0x2000, 0), [1, 2, 3, 4]);
}

#[test]
fn while_a_save_is_under_way_another_is_refused() {
    let mut storing = Storing::new(RamStore::default());
    storing.device.send(SAVE_ALL);
    assert!(storing.device.node.is_storing());
    // The client gives up and asks again.
    storing.device.send("604: 80 10 10 01 00 00 04 05");
    storing.device.send(LOAD_ALL);
    assert_eq!(storing.device.sent(), [abort(0x1011, 1, 0x0800_0022)]);
    while storing.device.node.is_storing() {
        storing.step();
    }
    storing.device.poll();
    assert_eq!(storing.device.sent(), [""; 0], "nobody waits for an answer");
    assert!(!storing.store.sets.iter().all(Vec::is_empty));
}

#[test]
fn a_node_without_a_store_boots_at_once() {
    let device = Device::new();
    assert!(!device.node.is_loading());
    let _: &Node<Objects> = &device.node;
}
