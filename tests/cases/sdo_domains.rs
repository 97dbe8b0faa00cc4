//! Long values, which the application gives and takes piece by piece: 2002h is a DOMAIN of any length.

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
