use std::vec::Vec;

use canopen::{BitRate, Frame};
use embedded_can::{ExtendedId, Frame as _, Id, StandardId};
use proptest::prelude::*;

use super::*;

fn decode(bytes: &[u8]) -> Vec<Command> {
    let mut decoder = Decoder::new();
    bytes
        .iter()
        .filter_map(|byte| decoder.push(*byte))
        .collect()
}

#[test]
fn frames_of_all_four_kinds_are_read() {
    let data = Frame::data_frame(0x604, &[0x40, 0, 0x10, 0, 0, 0, 0, 0xAB]);
    let extended = Frame::new(ExtendedId::new(0x1234_5678).unwrap(), &[1]).unwrap();
    let remote = Frame::new_remote(ExtendedId::new(0x0000_0001).unwrap(), 8).unwrap();
    assert_eq!(
        decode(b"t6048400010000000 00AB\rt60484000100000000 AB\r"),
        [Command::Malformed, Command::Malformed]
    );
    assert_eq!(
        decode(b"t604840001000000000AB\rT12345678101\rr7041\rR000000018\r"),
        [
            Command::Frame(data),
            Command::Frame(extended),
            Command::Frame(Frame::remote_frame(0x704, 1)),
            Command::Frame(remote),
        ]
    );
}

#[test]
fn what_python_can_sends_at_the_start_opens_the_channel() {
    let mut channel = Channel::new();
    for command in decode(b"C\rS8\r\rO\rO\r") {
        assert_eq!(channel.command(command).reply, OK);
    }
    assert!(channel.is_open());
    assert_eq!(
        channel.bit_rate().and_then(AdapterBitRate::bit_rate),
        Some(BitRate::Kbit1000)
    );
}

#[test]
fn other_commands_are_read() {
    assert_eq!(
        decode(b"L\rs031C\rV\rv\rN\rF\rZ0\rZ1\rM00000000\rmFFFFFFFF\rW0\rX1\rU2\r"),
        [
            Command::Listen,
            Command::SetBitTiming(0x031C),
            Command::Version,
            Command::Version,
            Command::SerialNumber,
            Command::Status,
            Command::TimeStamps(false),
            Command::TimeStamps(true),
            Command::Setting,
            Command::Setting,
            Command::Setting,
            Command::Setting,
            Command::Setting,
        ]
    );
}

#[test]
fn lines_that_are_wrong_are_malformed_and_the_next_is_read() {
    for line in [
        "t",
        "t60",
        "t604",
        "t6049",
        "t8000",
        "t604100G",
        "t6042000",
        "t604200000",
        "T200000000",
        "r60490",
        "r604100",
        "S9",
        "S",
        "S10",
        "s1",
        "s",
        "OO",
        "Z2",
        "x",
        "d6040",
        "M1",
        "+t6040",
        "t+040",
        "t6041+1",
    ] {
        let bytes = std::format!("{line}\rO\r");
        assert_eq!(
            decode(bytes.as_bytes()),
            [Command::Malformed, Command::Open],
            "{line}"
        );
    }
}

#[test]
fn a_line_of_any_length_is_one_error() {
    let mut bytes = std::vec![b't'; 10_000];
    bytes.extend_from_slice(b"\rC\r");
    assert_eq!(decode(&bytes), [Command::Malformed, Command::Close]);
}

#[test]
fn a_closed_channel_sends_nothing_and_an_open_one_keeps_its_bit_rate() {
    let frame = Frame::data_frame(0x000, &[1, 4]);
    let mut channel = Channel::new();
    let refused = Answer {
        reply: ERROR,
        frame: None,
    };
    assert_eq!(channel.command(Command::Frame(frame)), refused);
    channel.command(Command::Listen);
    assert!(channel.is_open());
    assert_eq!(channel.command(Command::Frame(frame)), refused);
    channel.command(Command::Open);
    assert_eq!(channel.command(Command::Frame(frame)).frame, Some(frame));
    let rate = AdapterBitRate::from(BitRate::Kbit500);
    assert_eq!(channel.command(Command::SetBitRate(rate)), refused);
    channel.command(Command::Close);
    assert_eq!(channel.command(Command::SetBitRate(rate)).reply, OK);
    assert_eq!(channel.bit_rate(), Some(rate));
}

#[test]
fn bit_rates_are_those_of_the_list() {
    for bit_rate in BitRate::ALL {
        assert_eq!(AdapterBitRate::from(bit_rate).bit_rate(), Some(bit_rate));
    }
    assert_eq!(
        AdapterBitRate::from_digit(3).map(AdapterBitRate::kbit_per_second),
        Some(100)
    );
    assert_eq!(
        AdapterBitRate::from_digit(3).and_then(AdapterBitRate::bit_rate),
        None
    );
    assert_eq!(AdapterBitRate::from_digit(9), None);
}

fn any_frame() -> impl Strategy<Value = Frame> {
    let id = prop_oneof![
        (0..=0x7FFu16).prop_map(|id| Id::Standard(StandardId::new(id).unwrap())),
        (0..=0x1FFF_FFFFu32).prop_map(|id| Id::Extended(ExtendedId::new(id).unwrap())),
    ];
    let data = prop::collection::vec(any::<u8>(), 0..=8);
    (id, data, any::<bool>()).prop_map(|(id, data, remote)| {
        if remote {
            Frame::new_remote(id, data.len()).unwrap()
        } else {
            Frame::new(id, &data).unwrap()
        }
    })
}

proptest! {
    #[test]
    fn every_frame_survives_its_line(frame in any_frame()) {
        let line = encode(&frame);
        prop_assert_eq!(decode(&line), [Command::Frame(frame)]);
    }

    #[test]
    fn any_bytes_give_one_command_a_line(bytes in prop::collection::vec(any::<u8>(), 0..2000)) {
        let lines = bytes.iter().filter(|byte| **byte == b'\r').count();
        prop_assert_eq!(decode(&bytes).len(), lines);
    }

    #[test]
    fn after_garbage_the_next_line_is_read(garbage in prop::collection::vec(any::<u8>(), 0..100), frame in any_frame()) {
        let mut bytes = garbage;
        bytes.push(b'\r');
        bytes.extend_from_slice(&encode(&frame));
        prop_assert_eq!(decode(&bytes).pop(), Some(Command::Frame(frame)));
    }

    #[test]
    fn a_changed_digit_never_panics(frame in any_frame(), place in 0usize..27, byte in any::<u8>()) {
        let mut line = encode(&frame);
        if let Some(changed) = line.get_mut(place) {
            *changed = byte;
        }
        decode(&line);
    }
}
