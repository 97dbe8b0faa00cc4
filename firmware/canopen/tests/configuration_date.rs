//! Verify configuration, 1020h: the date of a configuration stands as long as what it dates.

use crate::device::ram_store::RamStore;
use crate::parameters::{SAVE_ALL, Storing};
use canopen::cia301::nmt::Reset;

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
