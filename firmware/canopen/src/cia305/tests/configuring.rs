//! Configuring, storing, inquiring.

use super::{IDENTITY, START, fastscan, message, slave, word};
use crate::cia305::{LssEvent, Slave};
use crate::settings::StoreError;
use crate::settings::{BitRate, BitTiming, Configuration, NodeId, Settings, Sources, Wish};
use crate::time::{Instant, NEVER};

/// A slave on node-ID 4 in the configuration state.
fn in_configuration() -> Slave {
    let mut slave = slave(4);
    assert_eq!(slave.ask(&[0x04, 0x01]), None);
    slave
}

fn at(milliseconds: u64) -> Instant {
    Instant::from_ticks(START.ticks() + milliseconds * 1000)
}

#[test]
fn l01_nothing_is_told_in_the_waiting_state() {
    let mut slave = slave(4);
    for specifier in [0x5A, 0x5B, 0x5C, 0x5D, 0x5E, 0x11, 0x13, 0x15, 0x17] {
        assert_eq!(slave.ask(&[specifier, 0x0B]), None, "{specifier:02X}");
        assert_eq!(slave.event(), None);
    }
    assert_eq!(slave.pending_node_id().get(), 4);
}

#[test]
fn l02_the_node_id_is_told_in_the_configuration_state() {
    let mut slave = in_configuration();
    assert_eq!(slave.ask(&[0x5E]), Some(message(&[0x5E, 0x04])));
    slave.ask(&[0x04, 0x00]);
    assert_eq!(slave.ask(&[0x5E]), None);
}

#[test]
fn l02_a_mode_that_does_not_exist_changes_nothing() {
    let mut slave = in_configuration();
    assert_eq!(slave.ask(&[0x04, 0x02]), None);
    assert!(slave.is_in_configuration());
}

#[test]
fn l03_the_identity_is_told_word_by_word() {
    let mut slave = in_configuration();
    let words = [0x1122_3344, 0x5566_7788, 0x99AA_BBCC, 0xDDEE_FF01];
    for (specifier, expected) in (0x5A..).zip(words) {
        assert_eq!(slave.ask(&[specifier]), Some(word(specifier, expected)));
    }
}

#[test]
fn l04_a_node_id_is_1_to_127_or_255() {
    let mut slave = in_configuration();
    for number in 0..=255 {
        let before = slave.pending_node_id();
        let is_good = matches!(number, 1..=127 | 255);
        assert_eq!(
            slave.ask(&[0x11, number]),
            Some(message(&[0x11, u8::from(!is_good)]))
        );
        let expected = if is_good {
            NodeId::new(number).unwrap()
        } else {
            before
        };
        assert_eq!(slave.pending_node_id(), expected);
    }
    assert_eq!(slave.settings().node_id.get(), 4, "not in force yet");
}

#[test]
fn l05_a_bit_rate_that_is_not_there_is_refused() {
    let mut slave = in_configuration();
    for (table, index) in [(0, 5), (0, 9), (0, 0x63), (1, 0), (0x80, 0)] {
        assert_eq!(
            slave.ask(&[0x13, table, index]),
            Some(message(&[0x13, 0x01])),
            "{table} {index}"
        );
    }
    for bit_rate in BitRate::ALL {
        assert_eq!(
            slave.ask(&[0x13, 0, bit_rate.table_index()]),
            Some(message(&[0x13, 0x00]))
        );
    }
}

#[test]
fn l05_a_device_may_support_some_bit_rates_only() {
    let mut slave = slave(4).supporting(&[BitRate::Kbit500, BitRate::Kbit20]);
    slave.ask(&[0x04, 0x01]);
    for bit_rate in BitRate::ALL {
        let is_supported = matches!(bit_rate, BitRate::Kbit500 | BitRate::Kbit20);
        let answer = slave.ask(&[0x13, 0, bit_rate.table_index()]);
        assert_eq!(answer, Some(message(&[0x13, u8::from(!is_supported)])));
    }
}

#[test]
fn l05_automatic_detection_is_for_devices_that_can() {
    let mut slave = slave(4).detecting().supporting(&[BitRate::Kbit500]);
    slave.ask(&[0x04, 0x01]);
    assert_eq!(slave.ask(&[0x13, 0, 9]), Some(message(&[0x13, 0x00])));
    assert_eq!(slave.ask(&[0x13, 0, 5]), Some(message(&[0x13, 0x01])));
    slave.ask(&[0x17]);
    let stored = Configuration {
        node_id: NodeId::new(4).unwrap(),
        bit_timing: BitTiming::Automatic,
    };
    assert_eq!(slave.event(), Some(LssEvent::Store(stored)));
}

#[test]
fn l06_a_bit_rate_that_is_to_be_found_ends_the_silence() {
    let mut slave = slave(4).detecting();
    slave.ask(&[0x04, 0x01]);
    slave.ask(&[0x13, 0, 9]);
    slave.ask(&[0x15, 0xE8, 0x03]);
    let find = LssEvent::FindBitRate { at: at(1000) };
    assert_eq!(slave.event(), Some(find));
    assert_eq!(slave.poll(at(1000)), NEVER);
    assert!(slave.is_silent(at(1_000_000)));
    slave.bit_rate_found(BitRate::Kbit125);
    assert!(!slave.is_silent(at(1_000_000)));
    assert_eq!(slave.settings().bit_rate, BitRate::Kbit125);
}

/// A slave after a power-on: the switches ask for node 5 at 1 Mbit/s, stored is node 9 at 250 kbit/s.
fn switched(build: Wish) -> Slave {
    let sources = Sources {
        build,
        switches: Wish {
            node_id: NodeId::new(5),
            bit_timing: Some(BitTiming::Fixed(BitRate::Kbit1000)),
        },
        stored: Some(stored(9, BitRate::Kbit250)),
        ..Sources::default()
    };
    let power_on = sources.choose(&BitRate::ALL);
    let mut slave = slave(power_on.node_id.value.get()).started(&power_on);
    slave.ask(&[0x04, 0x01]);
    slave
}

fn stored(node_id: u8, bit_rate: BitRate) -> Configuration {
    Configuration {
        node_id: NodeId::new(node_id).unwrap(),
        bit_timing: BitTiming::Fixed(bit_rate),
    }
}

#[test]
fn what_is_not_configured_stays_stored_even_if_switches_go_before_it() {
    let mut slave = switched(Wish::NOTHING);
    assert_eq!(slave.ask(&[0x5E]), Some(message(&[0x5E, 5])));
    slave.ask(&[0x17]);
    let unchanged = LssEvent::Store(stored(9, BitRate::Kbit250));
    assert_eq!(slave.event(), Some(unchanged));
    slave.settings_stored(Ok(()));
    slave.ask(&[0x11, 7]);
    slave.ask(&[0x17]);
    let node_id_only = LssEvent::Store(stored(7, BitRate::Kbit250));
    assert_eq!(slave.event(), Some(node_id_only));
    // A reset before that would have left the device on the node-ID of the switches.
    assert_eq!(switched(Wish::NOTHING).reset().get(), 5);
    assert_eq!(slave.reset().get(), 7);
}

#[test]
fn what_the_build_has_fixed_cannot_be_configured() {
    let mut slave = switched(Wish {
        node_id: NodeId::new(3),
        bit_timing: None,
    });
    assert_eq!(slave.ask(&[0x11, 7]), Some(message(&[0x11, 0xFF, 0x01])));
    assert_eq!(slave.ask(&[0x11, 0]), Some(message(&[0x11, 0x01])));
    assert_eq!(slave.ask(&[0x13, 0, 2]), Some(message(&[0x13, 0x00])));
    assert_eq!(slave.reset().get(), 3);
    let mut slave = switched(Wish {
        node_id: None,
        bit_timing: Some(BitTiming::Fixed(BitRate::Kbit500)),
    });
    assert_eq!(slave.ask(&[0x13, 0, 3]), Some(message(&[0x13, 0xFF, 0x01])));
    assert_eq!(slave.ask(&[0x11, 7]), Some(message(&[0x11, 0x00])));
}

#[test]
fn l06_the_bit_rate_is_switched_between_two_silences() {
    let mut slave = in_configuration();
    assert_eq!(slave.ask(&[0x13, 0x00, 0x02]), Some(message(&[0x13, 0x00])));
    assert!(!slave.is_silent(START));
    assert_eq!(slave.ask(&[0x15, 0xE8, 0x03]), None);
    let switch = LssEvent::SwitchBitRate {
        bit_rate: BitRate::Kbit500,
        at: at(1000),
    };
    assert_eq!(slave.event(), Some(switch));
    assert_eq!(slave.event(), None);
    assert_eq!(slave.poll(START), at(1000));
    assert_eq!(slave.settings().bit_rate, BitRate::Kbit1000);
    assert!(slave.is_silent(START) && slave.is_silent(at(999)) && slave.is_silent(at(1000)));
    assert_eq!(
        slave.receive(&message(&[0x5E]), &IDENTITY, at(500)),
        None,
        "silent"
    );
    assert_eq!(slave.poll(at(1000)), at(2000));
    assert_eq!(slave.settings().bit_rate, BitRate::Kbit500);
    assert!(slave.is_silent(at(1999)) && !slave.is_silent(at(2000)));
    assert_eq!(slave.poll(at(2000)), NEVER);
    assert_eq!(
        slave.receive(&message(&[0x5E]), &IDENTITY, at(2000)),
        Some(message(&[0x5E, 0x04]))
    );
}

#[test]
fn l06_a_late_poll_misses_nothing() {
    let mut slave = in_configuration();
    slave.ask(&[0x13, 0x00, 0x04]);
    slave.ask(&[0x15, 0x0A, 0x00]);
    assert_eq!(slave.poll(at(5000)), NEVER);
    assert_eq!(slave.settings().bit_rate, BitRate::Kbit125);
}

#[test]
fn l06_no_delay_is_no_silence() {
    let mut slave = in_configuration();
    slave.ask(&[0x13, 0x00, 0x03]);
    slave.ask(&[0x15, 0x00, 0x00]);
    assert!(!slave.is_silent(START));
    assert_eq!(slave.poll(START), NEVER);
    assert_eq!(slave.settings().bit_rate, BitRate::Kbit250);
}

#[test]
fn l06_a_device_that_must_stay_reachable_is_not_silent_for_long() {
    for (delay, is_taken) in [
        (0_u16, true),
        (1_000, true),
        (1_001, false),
        (0xFFFF, false),
    ] {
        let mut slave = in_configuration();
        slave.stay_reachable(true);
        slave.ask(&[0x13, 0x00, 0x03]);
        let [low, high] = delay.to_le_bytes();
        assert_eq!(slave.ask(&[0x15, low, high]), None);
        assert_eq!(slave.event().is_some(), is_taken, "{delay} ms");
        assert_eq!(slave.is_silent(START), is_taken && delay > 0);
        slave.stay_reachable(false);
        if !is_taken {
            slave.ask(&[0x15, low, high]);
            assert!(slave.is_silent(START), "{delay} ms without power");
        }
    }
}

#[test]
fn l06_a_device_that_must_stay_reachable_looks_for_no_bit_rate() {
    let mut slave = slave(4).detecting();
    slave.ask(&[0x04, 0x01]);
    slave.ask(&[0x13, 0, 9]);
    slave.stay_reachable(true);
    slave.ask(&[0x15, 0x0A, 0x00]);
    assert!(slave.event().is_none() && !slave.is_silent(START));
    slave.stay_reachable(false);
    slave.ask(&[0x15, 0x0A, 0x00]);
    assert_eq!(slave.event(), Some(LssEvent::FindBitRate { at: at(10) }));
}

#[test]
fn l07_the_answer_to_store_is_its_result() {
    for (result, error) in [
        (Ok(()), 0),
        (Err(StoreError::NotSupported), 1),
        (Err(StoreError::Medium), 2),
    ] {
        let mut slave = in_configuration();
        slave.ask(&[0x11, 0x0B]);
        slave.ask(&[0x13, 0x00, 0x02]);
        assert_eq!(slave.ask(&[0x17]), None, "not before it is safe");
        let settings = Settings {
            node_id: NodeId::new(11).unwrap(),
            bit_rate: BitRate::Kbit500,
        };
        assert_eq!(slave.event(), Some(LssEvent::Store(settings.into())));
        assert_eq!(slave.settings_stored(result), Some(message(&[0x17, error])));
        assert_eq!(slave.settings_stored(result), None, "one answer");
    }
}

#[test]
fn l07_a_second_store_waits_for_the_first() {
    let mut slave = in_configuration();
    slave.ask(&[0x17]);
    assert!(slave.event().is_some());
    slave.ask(&[0x17]);
    assert_eq!(slave.event(), None);
    assert_eq!(slave.settings_stored(Err(StoreError::Medium)), None);
    assert!(slave.event().is_some());
    assert_eq!(slave.settings_stored(Ok(())), Some(message(&[0x17, 0])));
    assert_eq!(slave.event(), None);
    slave.ask(&[0x17]);
    assert!(slave.event().is_some());
}

#[test]
fn what_an_object_stores_is_told_to_no_lss_master() {
    let wish = Wish {
        node_id: NodeId::new(7),
        bit_timing: None,
    };
    let mut slave = in_configuration();
    slave.configure_and_store(&wish).unwrap();
    assert!(slave.is_storing());
    let stored_by_object = LssEvent::Store(stored(7, BitRate::Kbit1000));
    assert_eq!(slave.event(), Some(stored_by_object));
    assert_eq!(slave.settings_stored(Ok(())), None, "nobody has asked");
    assert!(!slave.is_storing());
    assert_eq!(slave.pending_node_id().get(), 7);
    // A master that asks meanwhile gets its answer when its own settings are stored.
    slave.configure_and_store(&wish).unwrap();
    slave.event();
    slave.ask(&[0x11, 8]);
    slave.ask(&[0x17]);
    assert_eq!(slave.settings_stored(Ok(())), None);
    let stored_by_master = LssEvent::Store(stored(8, BitRate::Kbit1000));
    assert_eq!(slave.event(), Some(stored_by_master));
    assert_eq!(slave.settings_stored(Ok(())), Some(message(&[0x17, 0])));
}

#[test]
fn an_object_configures_no_more_than_lss_does() {
    let unreachable = Wish {
        node_id: NodeId::new(7),
        bit_timing: Some(BitTiming::Fixed(BitRate::Kbit800)),
    };
    let mut slave = slave(4).supporting(&[BitRate::Kbit500]);
    assert!(slave.configure_and_store(&unreachable).is_err());
    assert_eq!(slave.pending_node_id().get(), 4, "nothing has changed");
    assert_eq!(slave.event(), None);
}

#[test]
fn l16_a_first_node_id_boots_the_device_when_it_is_let_go() {
    let mut slave = slave(255);
    slave.ask(&[0x04, 0x01]);
    slave.ask(&[0x11, 0x0B]);
    assert_eq!(slave.event(), None);
    assert_eq!(slave.ask(&[0x04, 0x00]), None);
    assert_eq!(slave.event(), Some(LssEvent::Boot));
    assert_eq!(slave.reset().get(), 11);
    assert_eq!(slave.settings().node_id.get(), 11);
    assert!(!slave.is_in_configuration());
    slave.ask(&[0x04, 0x00]);
    assert_eq!(slave.event(), None, "once");
}

#[test]
fn l16_without_a_node_id_nothing_boots() {
    let mut slave = slave(255);
    slave.ask(&[0x04, 0x01]);
    slave.ask(&[0x11, 0xFF]);
    slave.ask(&[0x04, 0x00]);
    assert_eq!(slave.event(), None);
    slave.ask(&[0x04, 0x01]);
    slave.ask(&[0x11, 0x0B]);
    slave.ask(&[0x04, 0x00]);
    assert_eq!(slave.event(), Some(LssEvent::Boot));
}

#[test]
fn l18_a_device_with_a_node_id_changes_it_at_reset_communication() {
    let mut slave = in_configuration();
    slave.ask(&[0x11, 0x0B]);
    slave.ask(&[0x04, 0x00]);
    assert_eq!(slave.event(), None);
    assert_eq!(slave.settings().node_id.get(), 4);
    assert_eq!(slave.pending_node_id().get(), 11);
    assert_eq!(slave.reset().get(), 11);
}

#[test]
fn l12_fastscan_is_not_for_the_configuration_state() {
    let mut slave = slave(255);
    slave.ask(&[0x04, 0x01]);
    assert_eq!(
        slave.receive(&fastscan(0, 128, 0, 0), &IDENTITY, START),
        None
    );
    slave.ask(&[0x04, 0x00]);
    assert!(
        slave
            .receive(&fastscan(0, 128, 0, 0), &IDENTITY, START)
            .is_some()
    );
}

/// A slave whose object was just told of node-ID 9 and 250 kbit/s; the store is at it.
fn told_by_an_object() -> Slave {
    let mut slave = in_configuration();
    slave.ask(&[0x11, 0x07]);
    let wish = Wish {
        node_id: NodeId::new(9),
        bit_timing: Some(BitTiming::Fixed(BitRate::Kbit250)),
    };
    slave.configure_and_store(&wish).unwrap();
    assert!(matches!(slave.event(), Some(LssEvent::Store(_))));
    slave
}

#[test]
fn what_an_object_was_told_takes_no_effect_if_it_cannot_be_stored() {
    let mut slave = told_by_an_object();
    assert_eq!(slave.settings_stored(Err(StoreError::Medium)), None);
    assert!(!slave.is_storing());
    let timing = BitTiming::Fixed(BitRate::Kbit1000);
    assert_eq!(slave.configuration().bit_timing, timing);
    assert_eq!(slave.configuration().node_id.get(), 7);
    assert_eq!(slave.reset().get(), 7);
}

#[test]
fn what_a_master_configures_meanwhile_stays_even_if_the_object_cannot_be_stored() {
    let mut slave = told_by_an_object();
    slave.ask(&[0x11, 0x09]);
    slave.settings_stored(Err(StoreError::Medium));
    let timing = BitTiming::Fixed(BitRate::Kbit1000);
    assert_eq!(slave.configuration().bit_timing, timing);
    assert_eq!(slave.reset().get(), 9);
}

#[test]
fn what_is_stored_stays_even_if_the_next_store_fails() {
    let mut slave = told_by_an_object();
    slave.settings_stored(Ok(()));
    slave.ask(&[0x17]);
    slave.settings_stored(Err(StoreError::Medium));
    assert_eq!(slave.reset().get(), 9);
}
