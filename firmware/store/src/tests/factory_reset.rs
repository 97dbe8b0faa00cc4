//! The factory reset, and the serial number that outlives it.

use canopen::cia301::parameters::{ParameterSet, ParameterSets, ParameterStore};
use canopen::{BitRate, BitTiming, Configuration, NodeId};

use super::{Flash, Refusal};
use crate::{Error, Store};

const CONFIGURED: Configuration = Configuration {
    node_id: NodeId::new(33).unwrap(),
    bit_timing: BitTiming::Fixed(BitRate::Kbit250),
};

const SERIAL_NUMBER: u32 = 0xCAFE_0402;

type Device = Flash<1024, 4>;

/// A device that has settings, one chunk in each set, and a serial number.
fn device() -> Device {
    let mut store = Device::new(2).store();
    store.save_serial_number(SERIAL_NUMBER).unwrap();
    store.save(&CONFIGURED).unwrap();
    store.begin(ParameterSets::ALL).unwrap();
    for set in ParameterSet::ALL {
        store.append(set, &[set as u8; 20]).unwrap();
    }
    store.commit().unwrap();
    store.release()
}

fn chunks(store: &mut Store<Device>) -> u16 {
    let sets = ParameterSet::ALL.into_iter();
    sets.map(|set| store.open(set).unwrap()).sum()
}

#[test]
fn everything_but_the_serial_number_is_forgotten() {
    let mut store = device().store();
    assert_eq!(chunks(&mut store), 4);
    store.forget().unwrap();
    let mut store = store.release().store();
    assert_eq!(store.load(), Ok(Some(Configuration::default())));
    assert_eq!(chunks(&mut store), 0);
    assert_eq!(store.serial_number(), Ok(Some(SERIAL_NUMBER)));
}

#[test]
fn an_input_that_is_stuck_costs_no_flash() {
    let mut store = device().store();
    store.forget().unwrap();
    let before = store.release();
    let mut store = before.clone().store();
    store.forget().unwrap();
    assert_eq!(store.release().bytes, before.bytes);
}

#[test]
fn a_device_that_has_stored_nothing_has_nothing_to_forget() {
    let mut store = Device::new(2).store();
    store.forget().unwrap();
    assert_eq!(store.load(), Ok(None));
}

#[test]
fn a_power_cut_at_any_byte_leaves_each_as_it_was_or_forgotten() {
    for cut in 1.. {
        let mut store = device().powered(cut).store();
        let finished = store.forget().is_ok();
        let mut store = store.release().powered(usize::MAX).store();
        let settings = store.load().unwrap().unwrap();
        assert!(settings == CONFIGURED || settings == Configuration::default());
        assert!(matches!(chunks(&mut store), 0 | 4));
        assert_eq!(store.serial_number(), Ok(Some(SERIAL_NUMBER)));
        // Given again, the order is carried out.
        store.forget().unwrap();
        assert_eq!(store.load(), Ok(Some(Configuration::default())));
        assert_eq!(chunks(&mut store), 0);
        if finished {
            break;
        }
    }
}

#[test]
fn a_reset_that_stumbles_forgets_nothing_and_the_next_one_everything() {
    let mut flash = device();
    flash.stumbles = true;
    let mut store = flash.store();
    assert_eq!(store.forget(), Err(Error::Flash(Refusal::Stumbled)));
    assert_eq!(store.load(), Ok(Some(CONFIGURED)));
    assert_eq!(chunks(&mut store), 4);
    store.forget().unwrap();
    assert_eq!(store.load(), Ok(Some(Configuration::default())));
    assert_eq!(chunks(&mut store), 0);
}

#[test]
fn a_serial_number_is_written_once() {
    let mut store = Device::new(2).store();
    assert_eq!(store.serial_number(), Ok(None));
    store.save_serial_number(5).unwrap();
    store.save_serial_number(5).unwrap();
    assert_eq!(store.save_serial_number(6), Err(Error::Content));
    assert_eq!(store.release().store().serial_number(), Ok(Some(5)));
}

#[test]
fn a_power_cut_leaves_the_serial_number_or_none() {
    for cut in 1.. {
        let mut store = Device::new(2).powered(cut).store();
        let finished = store.save_serial_number(5).is_ok();
        let mut store = store.release().powered(usize::MAX).store();
        let found = store.serial_number().unwrap();
        assert!(found.is_none_or(|number| number == 5));
        assert!(!finished || found.is_some());
        store.save_serial_number(5).unwrap();
        if finished {
            break;
        }
    }
}
