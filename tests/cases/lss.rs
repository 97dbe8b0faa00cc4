//! Layer setting services. The identity of the device is 11223344h, 55667788h, 99AABBCCh, DDEEFF01h.

use canopen::{BitRate, BitTiming};
use tests::Bench;

const VENDOR: &str = "44 33 22 11";
const PRODUCT: &str = "88 77 66 55";
const REVISION: &str = "CC BB AA 99";
const SERIAL: &str = "01 FF EE DD";

#[test]
fn l01_nothing_is_answered_in_the_waiting_state() {
    let mut bench = Bench::node(4);
    bench.send("7E5: 5E");
    bench.silence(100);
}

#[test]
fn l02_and_l03_the_configuration_state_tells_node_id_and_identity() {
    let mut bench = Bench::node(4);
    bench.send("7E5: 04 01");
    bench.silence(10);
    bench.send("7E5: 5E");
    bench.expect("7E4: 5E 04");
    for (command, word) in [
        ("5A", VENDOR),
        ("5B", PRODUCT),
        ("5C", REVISION),
        ("5D", SERIAL),
    ] {
        bench.send(&format!("7E5: {command}"));
        bench.expect(&format!("7E4: {command} {word}"));
    }
}

#[test]
fn l03_the_identity_is_told_word_by_word() {
    let mut bench = Bench::unconfigured();
    bench.send("7E5: 04 01");
    bench.send("7E5: 5D");
    bench.expect(&format!("7E4: 5D {SERIAL}"));
    bench.send("7E5: 5E");
    bench.expect("7E4: 5E FF");
}

#[test]
fn l04_node_ids_from_1_to_127_and_255_are_taken() {
    let mut bench = Bench::node(4);
    bench.send("7E5: 04 01");
    for (node_id, error) in [
        ("00", "01"),
        ("80", "01"),
        ("FE", "01"),
        ("0B", "00"),
        ("7F", "00"),
        ("FF", "00"),
    ] {
        bench.send(&format!("7E5: 11 {node_id}"));
        bench.expect(&format!("7E4: 11 {error}"));
    }
}

#[test]
fn l05_bit_timings_outside_table_0_are_refused() {
    let mut bench = Bench::node(4);
    bench.send("7E5: 04 01");
    for timing in ["00 05", "00 63", "01 00"] {
        bench.send(&format!("7E5: 13 {timing}"));
        bench.expect("7E4: 13 01");
    }
    for timing in ["00", "01", "02", "03", "04", "06", "07", "08"] {
        bench.send(&format!("7E5: 13 00 {timing}"));
        bench.expect("7E4: 13 00");
    }
}

#[test]
fn l08_selective_switching_takes_all_four_words() {
    let mut bench = Bench::unconfigured();
    bench.send(&format!("7E5: 40 {VENDOR}"));
    bench.send(&format!("7E5: 41 {PRODUCT}"));
    bench.send(&format!("7E5: 42 {REVISION}"));
    bench.silence(10);
    bench.send(&format!("7E5: 43 {SERIAL}"));
    bench.expect("7E4: 44");
    bench.send("7E5: 5E");
    bench.expect("7E4: 5E FF");
}

#[test]
fn l09_a_wrong_word_or_order_or_another_service_between_is_no_switch() {
    let words = [
        format!("40 {VENDOR}"),
        format!("41 {PRODUCT}"),
        format!("42 {REVISION}"),
        format!("43 {SERIAL}"),
    ];
    for broken in 0..4 {
        let mut bench = Bench::unconfigured();
        for (number, word) in words.iter().enumerate() {
            let command = &word[..2];
            let word = if number == broken {
                format!("{command} 99 99 99 99")
            } else {
                word.clone()
            };
            bench.send(&format!("7E5: {word}"));
        }
        bench.silence(50);
    }
    for order in [[1, 0, 2, 3], [0, 2, 1, 3], [0, 1, 3, 2]] {
        let mut bench = Bench::unconfigured();
        for number in order {
            bench.send(&format!("7E5: {}", words[number]));
        }
        bench.silence(50);
    }
    let mut bench = Bench::unconfigured();
    for (number, word) in words.iter().enumerate() {
        bench.send(&format!("7E5: {word}"));
        if number == 1 {
            bench.send("7E5: 5E");
        }
    }
    bench.silence(50);
}

#[test]
fn l10_identify_remote_slave_answers_within_the_range() {
    for configuration in [false, true] {
        let mut bench = Bench::node(4);
        if configuration {
            bench.send("7E5: 04 01");
        }
        for (low, high, hit) in [
            ("00 00 00 00", "FF FF FF FF", true),
            (SERIAL, SERIAL, true),
            ("02 FF EE DD", "FF FF FF FF", false),
        ] {
            bench.send(&format!("7E5: 46 {VENDOR}"));
            bench.send(&format!("7E5: 47 {PRODUCT}"));
            bench.send("7E5: 48 00 00 00 00");
            bench.send("7E5: 49 FF FF FF FF");
            bench.send(&format!("7E5: 4A {low}"));
            bench.send(&format!("7E5: 4B {high}"));
            if hit {
                bench.expect("7E4: 4F");
            } else {
                bench.silence(50);
            }
        }
    }
}

#[test]
fn l11_identify_non_configured_is_answered_by_those_only() {
    let mut bench = Bench::unconfigured();
    bench.send("7E5: 4C");
    bench.expect("7E4: 50");
    bench.send("7E5: 04 01");
    bench.send("7E5: 4C");
    bench.expect("7E4: 50");
    let mut bench = Bench::node(4);
    bench.send("7E5: 4C");
    bench.silence(100);
}

#[test]
fn l12_fastscan_begins_with_unconfigured_devices_only() {
    let mut bench = Bench::unconfigured();
    bench.send("7E5: 51 00 00 00 00 80 00 00");
    bench.expect("7E4: 4F");
    let mut bench = Bench::node(4);
    bench.send("7E5: 51 00 00 00 00 80 00 00");
    bench.silence(100);
}

#[test]
fn l13_fastscan_finds_the_identity_bit_by_bit() {
    let mut bench = Bench::unconfigured();
    bench.send("7E5: 51 00 00 00 00 80 00 00");
    bench.expect("7E4: 4F");
    let identity = [0x1122_3344_u32, 0x5566_7788, 0x99AA_BBCC, 0xDDEE_FF01];
    for (sub, expected) in identity.into_iter().enumerate() {
        let mut found = 0_u32;
        for bit in (0..32).rev() {
            let request = |number: u32, bit: u8, next: usize| {
                let [a, b, c, d] = number.to_le_bytes();
                format!("7E5: 51 {a:02X} {b:02X} {c:02X} {d:02X} {bit:02X} {sub:02X} {next:02X}")
            };
            bench.send(&request(found, bit, sub));
            if expected >> bit & 1 == 0 {
                bench.expect("7E4: 4F");
            } else {
                bench.silence(5);
                found |= 1 << bit;
            }
            if bit == 0 {
                bench.send(&request(found, 0, (sub + 1) % 4));
                bench.expect("7E4: 4F");
            }
        }
        assert_eq!(found, expected);
    }
    bench.send("7E5: 5E");
    bench.expect("7E4: 5E FF");
}

#[test]
fn l14_a_fastscan_that_makes_no_sense_is_ignored() {
    let mut bench = Bench::unconfigured();
    bench.send("7E5: 51 00 00 00 00 80 00 00");
    bench.expect("7E4: 4F");
    for request in [
        "51 00 00 00 00 20 00 00",
        "51 00 00 00 00 7F 00 00",
        "51 00 00 00 00 1F 04 00",
        "51 00 00 00 00 1F 01 01",
    ] {
        bench.send(&format!("7E5: {request}"));
        bench.silence(20);
    }
}

#[test]
fn l16_an_unconfigured_device_boots_when_it_leaves_configuration() {
    let mut bench = Bench::unconfigured();
    bench.send("7E5: 04 01");
    bench.send("7E5: 11 0B");
    bench.expect("7E4: 11 00");
    bench.send("7E5: 04 00");
    bench.expect("70B [1] 00");
    bench.send("60B: 40 00 10 00");
    bench.expect("58B: 43 00 10 00 ..");
}

#[test]
fn l17_only_data_frames_of_eight_bytes_count() {
    let mut bench = Bench::node(4);
    bench.send("7E5: 04 01");
    for request in ["7E5 [7] 5E", "7E5 [8] rtr", "000007E5: 5E"] {
        bench.send(request);
        bench.silence(20);
    }
}

#[test]
fn l18_a_configured_device_takes_its_new_node_id_with_reset_communication() {
    let mut bench = Bench::node(4);
    bench.start();
    bench.send("7E5: 04 01");
    bench.send("7E5: 11 0B");
    bench.expect("7E4: 11 00");
    bench.send("7E5: 04 00");
    bench.silence(50);
    bench.send("604: 40 00 10 00");
    bench.expect("584: 43 ..");
    bench.send("000 [2] 82 04");
    bench.expect("70B [1] 00");
}

#[test]
fn l19_an_unconfigured_device_answers_nothing_but_lss() {
    let mut bench = Bench::unconfigured();
    bench.silence(2_000);
    for request in [
        "000 [2] 01 00",
        "67F: 40 00 10 00",
        "604: 40 00 10 00",
        "080 [0]",
        "6FF: 40 00 10 00",
    ] {
        bench.send(request);
        bench.silence(20);
    }
}

#[test]
fn o03_identifiers_follow_the_node_id() {
    for node_id in [1_u8, 4, 127] {
        let mut bench = Bench::node(node_id);
        let id = u32::from(node_id);
        assert_eq!(bench.read_u32(0x1200, 1), 0x600 + id);
        assert_eq!(bench.read_u32(0x1200, 2), 0x580 + id);
        assert_eq!(bench.read_u32(0x1014, 0), 0x80 + id);
        assert_eq!(bench.read_u32(0x1800, 1) & 0x7FF, 0x180 + id);
    }
}

#[test]
fn l06_activation_is_silent_for_both_delays_and_switches_between_them() {
    let mut bench = Bench::node(4);
    bench.write_u16(0x1017, 0, 100);
    bench.drain(10);
    bench.send("7E5: 04 01");
    bench.send("7E5: 13 00 02");
    bench.expect("7E4: 13 00");
    bench.drain(1);
    bench.send("7E5: 15 E8 03");
    let began = bench.now();
    // The switch is up to the firmware; on this bus the device stays where it can be heard.
    bench.silence(1_990);
    let (bit_rate, at) = bench.device().bit_rates[0];
    assert_eq!(bit_rate.kbit_per_second(), 500);
    assert_eq!((at - began).to_millis(), 1_000);
    bench.drain_until("704 [1] 7F", 200);
}

#[test]
fn l07_storing_answers_what_became_of_it() {
    use canopen::node::StoreError;
    for (result, answer) in [
        (Ok(()), "7E4: 17 00"),
        (Err(StoreError::NotSupported), "7E4: 17 01"),
        (Err(StoreError::Medium), "7E4: 17 02"),
    ] {
        let mut bench = Bench::node(4);
        bench.device().store_result = result;
        bench.send("7E5: 04 01");
        bench.send("7E5: 11 0B");
        bench.expect("7E4: 11 00");
        bench.send("7E5: 13 00 03");
        bench.expect("7E4: 13 00");
        bench.send("7E5: 17");
        bench.expect(answer);
        let stored = bench
            .device()
            .stored
            .map(|stored| (stored.node_id.get(), stored.bit_timing));
        let wanted = (0x0B, BitTiming::Fixed(BitRate::Kbit250));
        assert_eq!(stored, result.is_ok().then_some(wanted));
    }
}
