//! SLCAN: any text of a client. Each line has one reply, a frame is sent where the channel is open alone, and whatever came before, the next
//! line is read.
#![no_main]

use libfuzzer_sys::fuzz_target;
use slcan::{Channel, Command, Decoder, ERROR, OK, encode};

fuzz_target!(|bytes: &[u8]| {
    let mut decoder = Decoder::new();
    let mut channel = Channel::new();
    for byte in bytes {
        let Some(command) = decoder.push(*byte) else {
            assert_ne!(*byte, b'\r');
            continue;
        };
        assert_eq!(*byte, b'\r');
        let was_open = channel.is_open();
        let answer = channel.command(command);
        assert!(answer.reply == ERROR || answer.reply.ends_with(OK));
        if let Some(frame) = answer.frame {
            assert!(was_open && answer.reply == OK);
            assert_eq!(command, Command::Frame(frame));
        }
        if let Command::Frame(frame) = command {
            assert_eq!(read(&mut Decoder::new(), &encode(&frame)), Some(command));
        }
    }
    // What is left of a line ends with its CR.
    decoder.push(b'\r');
    for line in ["C\r", "S8\r", "O\r"] {
        let command = read(&mut decoder, line.as_bytes()).unwrap();
        assert_eq!(channel.command(command).reply, OK, "{line}");
    }
    let command = read(&mut decoder, b"t60484003100000000000\r").unwrap();
    assert!(channel.command(command).frame.is_some());
});

/// The last command of these bytes.
fn read(decoder: &mut Decoder, bytes: &[u8]) -> Option<Command> {
    bytes.iter().filter_map(|byte| decoder.push(*byte)).last()
}
