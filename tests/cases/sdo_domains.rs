//! Long values, which the application gives and takes piece by piece: 2002h is a DOMAIN of any length.

use canopen::cia301::sdo::AbortCode;
use tests::{Bench, crc};

/// Bytes that tell where they belong.
fn data(length: usize) -> Vec<u8> {
    (0..length).map(|i| (i * 7 + i / 256) as u8).collect()
}

fn hex(bytes: &[u8]) -> String {
    let text: Vec<String> = bytes.iter().map(|byte| format!("{byte:02X}")).collect();
    text.join(" ")
}

#[test]
fn b20_two_sub_blocks_have_one_crc() {
    let mut bench = Bench::node(4);
    let value = data(127 * 7 + 1);
    bench.send("604: C6 02 20 00 7A 03");
    bench.expect("584: A4 02 20 00 7F");
    let mut segments = value.chunks(7);
    for number in 1..=127 {
        bench.send(&format!(
            "604: {number:02X} {}",
            hex(segments.next().unwrap())
        ));
    }
    bench.expect("584: A2 7F 7F");
    bench.send(&format!("604: 81 {}", hex(segments.next().unwrap())));
    bench.expect("584: A2 01 7F");
    bench.send(&format!("604: D9 {}", hex(&crc(&value).to_le_bytes())));
    bench.expect("584: A1");
    assert_eq!(bench.device().firmware.domains[&0x2002], value);

    bench.send("604: A4 02 20 00 7F");
    bench.expect("584: C6 02 20 00 7A 03");
    bench.send("604: A3");
    let mut segments = value.chunks(7);
    for number in 1..=127 {
        bench.expect(&format!(
            "584: {number:02X} {}",
            hex(segments.next().unwrap())
        ));
    }
    bench.silence(10);
    bench.send("604: A2 7F 7F");
    bench.expect(&format!("584: 81 {}", hex(segments.next().unwrap())));
    bench.send("604: A2 01 7F");
    bench.expect(&format!("584: D9 {}", hex(&crc(&value).to_le_bytes())));
    bench.send("604: A1");
    bench.silence(2_000);
}

#[test]
fn b27_a_domain_that_fails_ends_the_download_at_once() {
    for code in [AbortCode::HardwareError, AbortCode::NotTransferable] {
        let mut bench = Bench::node(4);
        bench.device().firmware.fails_at = Some((10, code));
        bench.send("604: C6 02 20 00 15");
        bench.expect("584: A4 02 20 00 7F");
        bench.send("604: 01 00 07 0E 15 1C 23 2A");
        bench.send("604: 02 31 38 3F 46 4D 54 5B");
        // A segment may be held back until the next tells that it was not the last.
        bench.queue("604: 83 62 69 70 77 7E 85 8C");
        bench.expect(&format!(
            "584: 80 02 20 00 {}",
            hex(&(code as u32).to_le_bytes())
        ));
        bench.silence(2_000);
        bench.send("604: 40 00 10 00");
        bench.expect("584: 43 00 10 00 ..");
        assert!(bench.device().firmware.domains.is_empty());
    }
}

#[test]
fn b27_a_domain_that_fails_ends_the_upload_at_once() {
    let mut bench = Bench::node(4);
    bench.device().firmware.domains.insert(0x2002, data(200));
    bench.device().firmware.fails_at = Some((150, AbortCode::HardwareError));
    bench.send("604: A4 02 20 00 7F");
    bench.expect("584: C6 02 20 00 C8");
    bench.send("604: A3");
    // The application is asked for 64 bytes at once, as many as the buffer of this device holds: 126 to 189 are refused.
    for (seqno, segment) in (1..).zip(data(126).chunks(7)) {
        bench.expect(&format!("584: {seqno:02X} {}", hex(segment)));
    }
    bench.expect("584: 80 02 20 00 00 00 06 06");
    bench.silence(2_000);
}

#[test]
fn a_write_that_the_client_gives_up_is_abandoned() {
    for end in ["604: 80 02 20 00 00 00 00 08", "604: 40 00 10 00"] {
        let mut bench = Bench::node(4);
        bench.send("604: 21 02 20 00 15");
        bench.expect("584: 60 02 20 00");
        bench.send("604: 00 00 07 0E 15 1C 23 2A");
        bench.expect("584: 20");
        bench.send(end);
        bench.drain(10);
        assert_eq!(bench.device().firmware.abandoned, 1, "{end}");
    }
    let mut bench = Bench::node(4);
    bench.send("604: C2 02 20 00 15");
    bench.expect("584: A4 02 20 00 7F");
    bench.drain(3_000);
    assert_eq!(bench.device().firmware.abandoned, 1, "by the time-out");
    bench.send("604: C2 02 20 00 15");
    bench.expect("584: A4 02 20 00 7F");
    bench.send("000 [2] 81 04");
    bench.expect("704 [1] 00");
    assert_eq!(bench.device().firmware.abandoned, 2, "by a reset");
}

#[test]
fn a_domain_of_unknown_size_is_read_to_its_end() {
    let mut bench = Bench::node(4);
    bench.device().firmware.domains.insert(0x2002, data(15));
    bench.device().firmware.hides_size = true;
    bench.send("604: 40 02 20 00");
    bench.expect("584: 40 02 20 00");
    bench.send("604: 60");
    bench.expect(&format!("584: 00 {}", hex(&data(15)[..7])));
    bench.send("604: 70");
    bench.expect(&format!("584: 10 {}", hex(&data(15)[7..14])));
    bench.send("604: 60");
    bench.expect(&format!("584: 0D {}", hex(&data(15)[14..])));

    bench.send("604: A4 02 20 00 7F");
    bench.expect("584: C4 02 20 00");
    bench.send("604: A3");
    bench.expect(&format!("584: 01 {}", hex(&data(15)[..7])));
    bench.expect(&format!("584: 02 {}", hex(&data(15)[7..14])));
    bench.expect(&format!("584: 83 {}", hex(&data(15)[14..])));
    bench.send("604: A2 03 7F");
    bench.expect(&format!("584: D9 {}", hex(&crc(&data(15)).to_le_bytes())));
    bench.send("604: A1");
    bench.silence(1_100);
}

#[test]
fn a_domain_of_every_length_goes_down_and_up_by_segments() {
    let mut bench = Bench::node(4);
    for length in (0..30).chain([889, 890, 2_000, 20_000]) {
        let value = data(length);
        bench.write(0x2002, 0, &value);
        assert_eq!(bench.device().firmware.domains[&0x2002], value, "{length}");
        assert_eq!(bench.read(0x2002, 0), value, "{length}");
    }
}

#[test]
fn a_domain_of_every_length_goes_down_and_up_by_blocks() {
    let mut bench = Bench::node(4);
    // From 65 segments on the last one and the end may begin with the same byte.
    for length in (0..30)
        .chain(450..640)
        .chain([888, 889, 890, 896, 1_778, 2_000, 20_000])
    {
        let value = data(length);
        bench.block_download(0x2002, 0, &value).unwrap();
        assert_eq!(bench.device().firmware.domains[&0x2002], value, "{length}");
        let sizes: &[u8] = if !(30..=800).contains(&length) {
            &[1, 2, 126, 127]
        } else {
            &[127]
        };
        for block_size in sizes.iter().copied() {
            let read = bench.block_upload(0x2002, 0, block_size);
            assert_eq!(read.as_deref(), Ok(&value[..]), "{length} by {block_size}");
        }
    }
}
