//! A device with each of the dictionaries boots, answers and takes values.

use canopen::cia301::nmt::{NmtState, Reset};
use canopen::od::Dictionary;
use canopen::{BitRate, Frame, Instant, Node, NodeId, Settings};

/// A device that has booted and said so.
fn booted<D: Dictionary>(dictionary: D) -> Node<D> {
    let settings = Settings {
        node_id: NodeId::new(4).unwrap(),
        bit_rate: BitRate::Kbit1000,
    };
    let now = Instant::from_ticks(0);
    let mut node = Node::new(dictionary, settings);
    node.boot(Reset::Node, now, &mut ());
    node.poll(now, &mut ());
    let boot_up = node.transmit(&mut ()).unwrap();
    assert_eq!(
        (boot_up.standard_id(), boot_up.payload()),
        (Some(0x704), &[0][..])
    );
    assert_eq!(node.state(), NmtState::PreOperational);
    node
}

/// The answer to an SDO request.
fn answer<D: Dictionary>(node: &mut Node<D>, request: [u8; 8]) -> [u8; 8] {
    let now = Instant::from_ticks(1000);
    node.receive(&Frame::full(0x604, request), now, &mut ());
    let answer = node.transmit(&mut ()).expect("an answer");
    assert_eq!(answer.standard_id(), Some(0x584));
    *answer.full_payload().unwrap()
}

/// Every entry that can be read is there; every other one says why not.
fn every_entry_answers<D: Dictionary>(dictionary: D) {
    let mut node = booted(dictionary);
    for entry in D::TABLE.entries {
        let [low, high] = entry.index.to_le_bytes();
        let answer = answer(&mut node, [0x40, low, high, entry.sub, 0, 0, 0, 0]);
        let code = u32::from_le_bytes([answer[4], answer[5], answer[6], answer[7]]);
        let is_fine = answer[0] & 0xE0 == 0x40;
        // Write only; no data; streamed by an application that is not here.
        let is_clear = answer[0] == 0x80 && matches!(code, 0x0601_0001 | 0x0800_0024 | 0x0601_0000);
        assert!(
            is_fine || is_clear,
            "{:04X}h:{}: {answer:02X?}",
            entry.index,
            entry.sub
        );
    }
}

#[test]
fn o01_every_entry_of_lmd_answers() {
    every_entry_answers(products::lmd::Dictionary::new());
}

#[test]
fn o01_every_entry_of_nanotec_answers() {
    every_entry_answers(products::nanotec::Dictionary::new());
}

#[test]
fn o01_every_entry_of_s200_answers() {
    every_entry_answers(products::s200::Dictionary::new());
}

#[test]
fn o01_every_entry_of_tc1_answers() {
    every_entry_answers(products::tc1::Dictionary::new());
}

/// The objects of their makers stand for what the bindings beside the data sheets say.
mod bindings {
    use canopen::cia301::sdo::AbortCode;
    use canopen::od::{self, Dictionary};
    use cia402::Objects;
    use products::{lmd, nanotec};

    /// Writes as a master does; the application of the drive is asked whether the number means something to it.
    fn set<D: Dictionary>(dictionary: &mut D, index: u16, sub: u8, bytes: &[u8]) {
        let entry = od::find::<D>(index, sub).unwrap();
        od::set(dictionary, entry, bytes).unwrap();
    }

    fn get<D: Dictionary>(dictionary: &D, index: u16, sub: u8) -> Vec<u8> {
        od::value(dictionary, od::find::<D>(index, sub).unwrap()).to_vec()
    }

    /// What is bound at its power-on value, and after a write, in the units of the drive.
    #[test]
    fn current_brake_and_inputs_of_the_nanotec_are_those_of_the_drive() {
        let mut dictionary = nanotec::Dictionary::new();
        assert_eq!(dictionary.hold_current(), 1500);
        assert_eq!(
            (dictionary.hold_delay(), dictionary.input_debounce()),
            (80, 20)
        );
        set(&mut dictionary, 0x2007, 2, &[0x2C, 1]);
        set(&mut dictionary, 0x2007, 3, &[100, 0]);
        assert_eq!(
            (
                dictionary.brake_release_time(),
                dictionary.brake_engage_time()
            ),
            (300, 100)
        );
        Objects::set_analogue_input_raw(&mut dictionary, 4095);
        assert_eq!(get(&dictionary, 0x2003, 3), 1024_u16.to_le_bytes());
    }

    #[test]
    fn supply_temperature_and_inputs_of_the_lmd_are_those_of_the_drive() {
        let mut dictionary = lmd::Dictionary::new();
        assert_eq!(
            (
                Objects::run_current(&dictionary),
                Objects::hold_current(&dictionary)
            ),
            (1500, 150)
        );
        assert_eq!(dictionary.under_voltage_warning(), 10_000);
        assert_eq!(dictionary.over_voltage_warning(), 58_000);
        assert_eq!(
            (
                dictionary.temperature_warning(),
                dictionary.over_temperature_fault()
            ),
            (800, 850)
        );
        Objects::set_dc_link_voltage(&mut dictionary, 44_770);
        assert_eq!(get(&dictionary, 0x2015, 1), 448_u16.to_le_bytes());
        Objects::set_temperature(&mut dictionary, -56);
        assert_eq!(get(&dictionary, 0x2019, 1), (-6_i8).to_le_bytes());
        set(&mut dictionary, 0x2000, 4, &[0b101]);
        assert_eq!(dictionary.inputs_inverted(), 0b101);
        Objects::set_touch_probe_1_positive_edge(&mut dictionary, -7);
        assert_eq!(get(&dictionary, 0x2033, 4), (-7_i32).to_le_bytes());
    }

    #[test]
    fn codes_of_the_lmd_mean_what_its_manual_says() {
        let mut dictionary = lmd::Dictionary::new();
        assert_eq!(dictionary.analogue_input_full_scale(), 5000);
        set(&mut dictionary, 0x2010, 2, &[8]);
        assert_eq!(dictionary.analogue_input_full_scale(), 10_000);
        let mode = od::find::<lmd::Dictionary>(0x2010, 2).unwrap();
        assert_eq!(
            lmd::Dictionary::converted(mode, 2),
            Err(AbortCode::InvalidValue)
        );
        for (polarity, direction) in [(0_i8, 0), (127, 0), (-1, 1), (-128, 1)] {
            set(&mut dictionary, 0x2030, 0, &polarity.to_le_bytes());
            assert_eq!(dictionary.motor_direction(), direction, "{polarity}");
        }
        set(&mut dictionary, 0x2033, 1, &[1]);
        assert_eq!(dictionary.touch_probe_function(), 0x13);
    }

    #[test]
    fn what_the_s200_shows_twice_is_the_same() {
        let mut dictionary = products::s200::Dictionary::new();
        Objects::set_position_actual_value(&mut dictionary, 77);
        assert_eq!(dictionary.pfb_value(), 77);
        assert_eq!(dictionary.position_actual_value_user_units(), 77);
    }

    #[test]
    fn what_happens_to_be_at_a_place_of_ours_stays_what_it_is() {
        let mut dictionary = lmd::Dictionary::new();
        dictionary.set_bridge_on_settle_time_bridge_on_settle_time(250);
        Objects::set_homing_failure(&mut dictionary, 3);
        assert_eq!(
            dictionary.bridge_on_settle_time_bridge_on_settle_time(),
            250
        );
    }

    #[test]
    fn a_write_to_one_object_shows_in_the_other() {
        let mut dictionary = products::s200::Dictionary::new();
        let stop = od::find::<products::s200::Dictionary>(0x3525, 1).unwrap();
        assert!(od::set(&mut dictionary, stop, &500_i32.to_le_bytes()).is_ok());
        dictionary.carry_over(stop);
        assert_eq!(Objects::quick_stop_deceleration(&dictionary), 500);
        assert!(dictionary.ram().len() > 1000);
    }
}
