//! Store and restore parameters: 1010h, 1011h, 1020h, on a store in memory.

use crate::device::ram_store::RamStore;
use crate::device::{Device, Objects, abort};
use canopen::Node;
use canopen::cia301::nmt::Reset;
use canopen::cia301::parameters::ParameterSet;
use canopen::cia301::sdo::AbortCode;
use canopen::od::Dictionary;

const SAVE_ALL: &str = "604: 23 10 10 01 73 61 76 65";
const SAVED_ALL: &str = "584: 60 10 10 01 00 00 00 00";
const LOAD_ALL: &str = "604: 23 11 10 01 6C 6F 61 64";
const LOADED_ALL: &str = "584: 60 11 10 01 00 00 00 00";

/// A device with a store.
struct Storing {
    device: Device,
    store: RamStore,
}

impl Storing {
    /// Node 4 in Pre-operational, its boot-up message gone.
    fn new(store: RamStore) -> Self {
        Self::with_node_id(4, store)
    }

    fn with_node_id(node_id: u8, store: RamStore) -> Self {
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

    fn boot(&mut self, reset: Reset) {
        self.device.boot(reset);
        assert!(self.device.node.is_loading());
        assert_eq!(self.device.sent(), [""; 0]);
        let now = self.device.now;
        self.device
            .node
            .load_parameters(&mut self.store, now, &mut self.device.firmware);
    }

    /// Power off and on again.
    fn power_cycle(self) -> Self {
        Self::new(self.store)
    }

    fn step(&mut self) {
        let now = self.device.now;
        self.device.node.store_parameters(&mut self.store, now);
    }

    /// Sends a request, stores as long as there is something to store, and returns what was sent.
    fn ask(&mut self, text: &str) -> Vec<String> {
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

    fn value(&self, index: u16, sub: u8) -> Vec<u8> {
        self.device.value(index, sub)
    }

    /// Writes an object by SDO.
    fn write(&mut self, index: u16, sub: u8, bytes: &[u8]) {
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
fn a_changed_pdo_is_back_after_the_reset() {
    let mut storing = Storing::new(RamStore::default());
    // TPDO 1: off, empty, one object, on with another identifier and an inhibit time.
    storing.write(0x1800, 1, &[0x84, 0x01, 0, 0xC0]);
    storing.write(0x1A00, 0, &[0]);
    storing.write(0x1A00, 1, &[32, 0, 0x06, 0x20]);
    storing.write(0x1A00, 0, &[1]);
    storing.write(0x1800, 3, &[100, 0]);
    storing.write(0x1800, 1, &[0x85, 0x01, 0, 0x40]);
    assert_eq!(storing.ask(SAVE_ALL), [SAVED_ALL]);
    let mut storing = storing.power_cycle();
    assert_eq!(storing.value(0x1800, 1), [0x85, 0x01, 0, 0x40]);
    assert_eq!(storing.value(0x1800, 3), [100, 0]);
    assert_eq!(storing.value(0x1A00, 0), [1]);
    storing.device.send("000 [2] 01 04");
    assert_eq!(storing.device.sent(), ["185 [4] 00 00 00 00"]);
}

#[test]
fn cob_ids_of_the_data_sheet_follow_a_new_node_id_and_others_do_not() {
    let mut storing = Storing::new(RamStore::default());
    storing.write(0x1401, 1, &[0x33, 0x02, 0, 0]);
    storing.ask(SAVE_ALL);
    let storing = Storing::with_node_id(9, storing.store);
    assert_eq!(storing.value(0x1014, 0), [0x89, 0, 0, 0]);
    assert_eq!(storing.value(0x1400, 1), [0x09, 0x02, 0, 0]);
    assert_eq!(storing.value(0x1401, 1), [0x33, 0x02, 0, 0]);
}

#[test]
fn an_identifier_that_must_be_switched_off_first_is_loaded() {
    let mut storing = Storing::new(RamStore::default());
    storing.write(0x1014, 0, &[0x84, 0, 0, 0x80]);
    storing.write(0x1014, 0, &[0xA4, 0, 0, 0]);
    storing.ask(SAVE_ALL);
    let storing = storing.power_cycle();
    assert_eq!(storing.value(0x1014, 0), [0xA4, 0, 0, 0]);
}

#[test]
fn identifiers_that_have_changed_hands_are_loaded_whole() {
    let mut storing = Storing::new(RamStore::default());
    // SYNC and EMCY go elsewhere, and the transmit PDOs take what they had.
    storing.write(0x1005, 0, &[0x90, 0, 0, 0]);
    storing.write(0x1014, 0, &[0x84, 0, 0, 0x80]);
    storing.write(0x1014, 0, &[0xA4, 0, 0, 0]);
    for (index, cob_id) in [(0x1800, 0x80), (0x1801, 0x84)] {
        storing.write(index, 1, &[cob_id, 0, 0, 0xC0]);
        storing.write(index, 1, &[cob_id, 0, 0, 0x40]);
    }
    assert_eq!(storing.ask(SAVE_ALL), [SAVED_ALL]);
    let mut storing = storing.power_cycle();
    assert_eq!(storing.value(0x1005, 0), [0x90, 0, 0, 0]);
    assert_eq!(storing.value(0x1014, 0), [0xA4, 0, 0, 0]);
    assert_eq!(storing.value(0x1800, 1), [0x80, 0, 0, 0x40]);
    assert_eq!(storing.value(0x1801, 1), [0x84, 0, 0, 0x40]);
    storing.device.poll();
    assert_eq!(storing.device.sent(), [""; 0], "nothing was refused");
}

#[test]
fn r08_a_pdo_whose_identifier_another_service_has_now_is_switched_off_and_told() {
    let mut storing = Storing::new(RamStore::default());
    storing.write(0x1800, 1, &[0x85, 0, 0, 0xC0]);
    storing.write(0x1800, 1, &[0x85, 0, 0, 0x40]);
    assert_eq!(storing.ask(SAVE_ALL), [SAVED_ALL]);
    // With node-ID 5 that is the identifier of its emergency messages.
    let mut storing = Storing::just_booted(Device::off_with(5), storing.store);
    assert_eq!(storing.value(0x1014, 0), [0x85, 0, 0, 0]);
    assert_eq!(storing.value(0x1800, 1), [0x85, 0, 0, 0xC0]);
    assert_eq!(
        storing.device.sent(),
        ["705 [1] 00", "085: 20 63 01 00 18 01 01 00"]
    );
}

#[test]
fn r08_a_new_firmware_keeps_what_fits_and_reports_the_rest_once() {
    let mut store = RamStore::default();
    store.put(
        ParameterSet::Manufacturer,
        &[
            (0x2000, 0, &[1, 2, 3, 4]),
            (0x2008, 0, &[99]),         // above its limit
            (0x2009, 0, &[1, 0]),       // not stored any more
            (0x2013, 0, &[1, 0, 0, 0]), // another length
            (0x2FFF, 0, &[1]),          // gone
        ],
    );
    store.put(ParameterSet::Application, &[(0x6081, 0, &[44, 0, 0, 0])]);
    let mut storing = Storing::with_node_id_and_messages(store);
    assert_eq!(storing.value(0x2000, 0), [1, 2, 3, 4]);
    assert_eq!(storing.value(0x2008, 0), [15]);
    assert_eq!(storing.value(0x2013, 0), [0, 0]);
    assert_eq!(storing.value(0x6081, 0), [44, 0, 0, 0]);
    assert_eq!(
        storing.device.sent(),
        ["704 [1] 00", "084: 20 63 01 08 20 00 04 00"]
    );
    // What is there now is stored: nothing is left that does not fit.
    assert_eq!(
        storing.ask(SAVE_ALL),
        ["084: 00 00 00 00 00 00 00 00", SAVED_ALL]
    );
    let mut again = Storing::with_node_id_and_messages(storing.store);
    assert_eq!(again.device.sent(), ["704 [1] 00"]);
}

impl Storing {
    /// Node 4 just booted, with what it has to say.
    fn with_node_id_and_messages(store: RamStore) -> Self {
        Self::just_booted(Device::off(), store)
    }

    /// Just booted, with what it has to say.
    fn just_booted(off: Device, store: RamStore) -> Self {
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
}

#[test]
fn r08_a_pdo_that_maps_what_is_gone_is_that_of_the_data_sheet() {
    let mut store = RamStore::default();
    store.put(
        ParameterSet::Communication,
        &[
            (0x1800, 2, &[1]),
            (0x1A00, 1, &[32, 0, 0xFF, 0x2F]),
            (0x1A00, 2, &[32, 0, 0x05, 0x20]),
            (0x1A00, 0, &[2]),
            (0x1800, 1, &[0x85, 0x01, 0, 0x40]),
            (0x1801, 2, &[1]),
            (0x1A01, 1, &[32, 0, 0x06, 0x20]),
            (0x1A01, 0, &[1]),
            (0x1801, 1, &[0x85, 0x02, 0, 0x40]),
        ],
    );
    let mut storing = Storing::with_node_id_and_messages(store);
    assert_eq!(
        storing.device.sent(),
        ["704 [1] 00", "084: 20 63 01 00 1A 01 04 00"]
    );
    assert_eq!(storing.value(0x1800, 1), [0x84, 0x01, 0, 0x40]);
    assert_eq!(storing.value(0x1800, 2), [255]);
    assert_eq!(storing.value(0x1A00, 1), [32, 0, 0x05, 0x20]);
    assert_eq!(storing.value(0x1801, 1), [0x85, 0x02, 0, 0x40]);
    assert_eq!(storing.value(0x1A01, 0), [1]);
}

#[test]
fn r08_a_pdo_without_its_cob_id_is_that_of_the_data_sheet() {
    let mut store = RamStore::default();
    store.put(ParameterSet::Communication, &[(0x1800, 2, &[1])]);
    let mut storing = Storing::with_node_id_and_messages(store);
    assert_eq!(
        storing.device.sent(),
        ["704 [1] 00", "084: 20 63 01 00 18 01 01 00"]
    );
    assert_eq!(storing.value(0x1800, 1), [0x84, 0x01, 0, 0x40]);
    assert_eq!(storing.value(0x1800, 2), [255]);
}

#[test]
fn a_damaged_set_is_left_alone_and_told() {
    let mut storing = Storing::new(RamStore::default());
    storing.write(0x2000, 0, &[1, 2, 3, 4]);
    storing.write(0x6081, 0, &[1, 0, 0, 0]);
    storing.ask(SAVE_ALL);
    storing.store.damaged = Some(ParameterSet::Manufacturer);
    let mut storing = Storing::with_node_id_and_messages(storing.store);
    assert_eq!(storing.value(0x2000, 0), [0x78, 0x56, 0x34, 0x12]);
    assert_eq!(storing.value(0x6081, 0), [1, 0, 0, 0]);
    assert_eq!(
        storing.device.sent(),
        ["704 [1] 00", "084: 10 63 01 04 00 00 00 00"]
    );
}

#[test]
fn r09_a_changed_parameter_makes_the_configuration_date_zero() {
    let mut storing = Storing::new(RamStore::default());
    storing.write(0x2000, 0, &[1, 2, 3, 4]);
    storing.write(0x1020, 1, &[0xD5, 0x3C, 0, 0]);
    storing.write(0x1020, 2, &[0x40, 0x0D, 0x03, 0x00]);
    storing.ask(SAVE_ALL);
    assert_eq!(storing.value(0x1020, 1), [0xD5, 0x3C, 0, 0]);
    let mut storing = storing.power_cycle();
    assert_eq!(storing.value(0x1020, 1), [0xD5, 0x3C, 0, 0]);
    assert_eq!(storing.value(0x1020, 2), [0x40, 0x0D, 0x03, 0x00]);
    // The value that is there is no change, and neither is one that is not stored.
    storing.write(0x2000, 0, &[1, 2, 3, 4]);
    storing.write(0x2009, 0, &[1, 0]);
    assert_eq!(storing.value(0x1020, 1), [0xD5, 0x3C, 0, 0]);
    storing.write(0x2000, 0, &[1, 2, 3, 5]);
    assert_eq!(storing.value(0x1020, 1), [0; 4]);
    assert_eq!(storing.value(0x1020, 2), [0; 4]);
    // Nothing was saved, so the configuration of the next start is the dated one.
    let storing = storing.power_cycle();
    assert_eq!(storing.value(0x1020, 1), [0xD5, 0x3C, 0, 0]);
}

#[test]
fn r09_a_reset_of_the_communication_does_not_bring_back_the_date_of_another_configuration() {
    const DATE: [u8; 4] = [0xD5, 0x3C, 0, 0];
    let dated = || {
        let mut storing = Storing::new(RamStore::default());
        storing.write(0x2000, 0, &[1, 2, 3, 4]);
        storing.write(0x1020, 1, &DATE);
        storing.ask(SAVE_ALL);
        storing
    };
    // What this reset loads is the dated configuration again.
    let mut storing = dated();
    storing.write(0x1015, 0, &[5, 0]);
    assert_eq!(storing.value(0x1020, 1), [0; 4]);
    storing.boot(Reset::Communication);
    assert_eq!(storing.value(0x1020, 1), DATE);
    // What it leaves alone is not, whatever date a master has written without saving.
    for unsaved in [None, Some([0; 4]), Some([9, 9, 0, 0])] {
        let mut storing = dated();
        if unsaved == Some([0; 4]) {
            storing.write(0x1020, 1, &[0; 4]);
        }
        storing.write(0x2000, 0, &[4, 3, 2, 1]);
        if let Some(date) = unsaved {
            storing.write(0x1020, 1, &date);
        }
        for _ in 0..2 {
            storing.boot(Reset::Communication);
            assert_eq!(storing.value(0x2000, 0), [4, 3, 2, 1]);
            assert_eq!(storing.value(0x1020, 1), [0; 4], "{unsaved:?}");
        }
        storing.boot(Reset::Node);
        storing.device.sent();
        assert_eq!(storing.value(0x1020, 1), DATE);
        // Saved with its own date it is the configuration.
        storing.write(0x2000, 0, &[4, 3, 2, 1]);
        storing.write(0x1020, 1, &[8, 8, 0, 0]);
        storing.ask(SAVE_ALL);
        storing.boot(Reset::Communication);
        assert_eq!(storing.value(0x1020, 1), [8, 8, 0, 0]);
    }
}

#[test]
fn r08_a_device_without_a_node_id_tells_what_does_not_fit_when_it_has_one() {
    let mut store = RamStore::default();
    store.put(
        ParameterSet::Manufacturer,
        &[(0x2000, 0, &[1, 2, 3, 4]), (0x2008, 0, &[99])],
    );
    let mut storing = Storing::just_booted(Device::off_with(255), store);
    assert_eq!(storing.value(0x2000, 0), [1, 2, 3, 4]);
    assert_eq!(storing.value(0x1001, 0), [0]);
    assert_eq!(storing.device.sent(), [""; 0]);
    for request in [
        "7E5: 04 01 00 00 00 00 00 00",
        "7E5: 11 04 00 00 00 00 00 00",
        "7E5: 04 00 00 00 00 00 00 00",
    ] {
        storing.device.ask(request);
    }
    storing.boot(Reset::Communication);
    storing.device.poll();
    assert_eq!(
        storing.device.sent(),
        ["704 [1] 00", "084: 20 63 01 08 20 00 01 00"]
    );
    // Another reset changes nothing: the value is still not the stored one.
    storing.boot(Reset::Communication);
    storing.device.poll();
    assert_eq!(
        storing.device.sent(),
        ["704 [1] 00", "084: 20 63 01 08 20 00 01 00"]
    );
}

#[test]
fn r08_an_error_of_the_last_loading_does_not_outlive_it() {
    let mut storing = Storing::new(RamStore::default());
    storing.ask(SAVE_ALL);
    let good = storing.store.clone();
    storing.store.put(
        ParameterSet::Communication,
        &[(0x1014, 0, &[0x84, 0, 0, 0]), (0x1029, 1, &[77])],
    );
    storing.boot(Reset::Communication);
    assert_eq!(storing.value(0x1001, 0), [1]);
    storing.store = good.clone();
    storing.store.damaged = Some(ParameterSet::Manufacturer);
    storing.boot(Reset::Communication);
    assert_eq!(storing.value(0x1001, 0), [1]);
    storing.store = good;
    storing.boot(Reset::Communication);
    assert_eq!(storing.value(0x1001, 0), [0]);
}

#[test]
fn h03_watched_nodes_change_places_behind_one_that_stays() {
    let watched = [0x0005_03E8, 0x0006_03E8, 0x0007_03E8];
    let [first, second, third] = watched.map(u32::to_le_bytes);
    let mut store = RamStore::default();
    store.put(
        ParameterSet::Communication,
        &[
            (0x1016, 1, &first),
            (0x1016, 2, &third),
            (0x1016, 3, &second),
        ],
    );
    let mut off = Device::off();
    off.firmware.watched = watched;
    let mut storing = Storing::just_booted(off, store);
    assert_eq!(storing.device.sent(), ["704 [1] 00"]);
    assert_eq!(storing.value(0x1016, 1), first);
    assert_eq!(storing.value(0x1016, 2), third);
    assert_eq!(storing.value(0x1016, 3), second);
}

#[test]
fn r09_restoring_one_group_forgets_the_date_of_all() {
    let mut storing = Storing::new(RamStore::default());
    storing.write(0x1020, 1, &[0xD5, 0x3C, 0, 0]);
    storing.ask(SAVE_ALL);
    assert_eq!(
        storing.ask("604: 23 11 10 04 6C 6F 61 64"),
        ["584: 60 11 10 04 00 00 00 00"]
    );
    assert_eq!(storing.value(0x1020, 1), [0; 4]);
    let storing = storing.power_cycle();
    assert_eq!(storing.value(0x1020, 1), [0; 4]);
}

#[test]
fn what_is_stored_is_what_a_master_would_write() {
    let mut storing = Storing::new(RamStore::default());
    storing.ask(SAVE_ALL);
    let records = storing.store.records(ParameterSet::Communication);
    let order: Vec<(u16, u8)> = records
        .iter()
        .map(|(index, sub, _)| (*index, *sub))
        .collect();
    let first = order
        .iter()
        .position(|entry| *entry == (0x1800, 2))
        .unwrap();
    assert_eq!(
        order[first..first + 4],
        [(0x1800, 2), (0x1800, 3), (0x1800, 5), (0x1800, 6)]
    );
    assert_eq!(order[first + 4], (0x1A00, 1));
    assert_eq!(order[first + 12..first + 14], [(0x1A00, 0), (0x1800, 1)]);
    assert_eq!(order.last(), Some(&(0x1005, 0)));
    // Every stored entry once.
    let mut sorted = order.clone();
    sorted.sort_unstable();
    sorted.dedup();
    assert_eq!(sorted.len(), order.len());
    let stored = Objects::TABLE
        .entries
        .iter()
        .filter(|entry| entry.storage_group().is_some() && entry.index / 0x1000 == 1);
    assert_eq!(
        order.len(),
        stored.filter(|entry| entry.index != 0x1020).count()
    );
    let text = storing.store.records(ParameterSet::Manufacturer);
    assert!(text.contains(&(0x2001, 0, b"hello".to_vec())));
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
