//! What a start loads: parameters as a master would write them, and what does not fit any more.

use crate::device::ram_store::RamStore;
use crate::device::{Device, Objects};
use crate::parameters::{SAVE_ALL, SAVED_ALL, Storing};
use canopen::cia301::nmt::Reset;
use canopen::cia301::parameters::ParameterSet;
use canopen::od::Dictionary;

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
