//! Block uploads: the server sends sub-blocks of as many segments as the client asks for, the client acknowledges each.

use tests::Bench;

/// The vendor-ID, 11223344h, after the initiate: one segment.
fn begun(bench: &mut Bench) {
    bench.send("604: A4 18 10 01 14");
    bench.expect("584: C6 18 10 01 04");
}

#[test]
fn b03_four_bytes_without_crc() {
    let mut bench = Bench::node(4);
    bench.send("604: A0 18 10 01 14");
    bench.expect("584: C6 18 10 01 04");
    bench.send("604: A3");
    bench.expect("584: 81 44 33 22 11");
    bench.send("604: A2 01 14");
    bench.expect("584: CD");
    bench.send("604: A1");
    bench.silence(2_000);
}

#[test]
fn b04_four_bytes_with_crc() {
    let mut bench = Bench::node(4);
    bench.write_u32(0x2000, 0, 0x000F_0191);
    bench.send("604: A4 00 20 00 14");
    bench.expect("584: C6 00 20 00 04");
    bench.send("604: A3");
    bench.expect("584: 81 91 01 0F 00");
    bench.send("604: A2 01 14");
    bench.expect("584: CD 25 97");
    bench.send("604: A1");
    bench.silence(2_000);
}

#[test]
fn b05_block_sizes_beyond_1_to_127_are_refused() {
    let mut bench = Bench::node(4);
    bench.refused("604: A4 18 10 01 00", 0x0504_0002);
    bench.refused("604: A4 18 10 01 80", 0x0504_0002);
    for ack in ["604: A2 01 00", "604: A2 01 80"] {
        bench.send("604: A4 01 20 00 01");
        bench.expect("584: C6 01 20 00 40");
        bench.send("604: A3");
        bench.expect("584: 01 41 42 43 44 45 46 47");
        bench.send(ack);
        bench.expect("584: 80 01 20 00 02 00 04 05");
    }
    // After the last segment there is no next sub-block, so its size means nothing.
    begun(&mut bench);
    bench.send("604: A3");
    bench.expect("584: 81 44 33 22 11");
    bench.send("604: A2 01 00");
    bench.expect("584: CD ..");
    bench.send("604: A1");
}

#[test]
fn b06_more_segments_than_were_sent_cannot_be_acknowledged() {
    for ack in ["604: A2 80 14", "604: A2 02 14", "604: A2 7F 14"] {
        let mut bench = Bench::node(4);
        begun(&mut bench);
        bench.send("604: A3");
        bench.expect("584: 81 44 33 22 11");
        bench.send(ack);
        bench.expect("584: 80 18 10 01 03 00 04 05");
    }
}

#[test]
fn b07_two_acknowledged_of_one_sent_are_refused() {
    let mut bench = Bench::node(4);
    bench.send("604: A4 01 20 00 01");
    bench.expect("584: C6 01 20 00 40");
    bench.send("604: A3");
    bench.expect("584: 01 41 42 43 44 45 46 47");
    bench.send("604: A2 02 01");
    bench.expect("584: 80 01 20 00 03 00 04 05");
}

#[test]
fn b17_what_cannot_be_read_is_refused_at_once() {
    let mut bench = Bench::node(4);
    bench.refused("604: A4 09 20 00 7F", 0x0601_0001);
    bench.refused("604: A4 FF 5F 00 7F", 0x0602_0000);
    bench.refused("604: A4 18 10 09 7F", 0x0609_0011);
    bench.refused("604: A4 03 10 01 7F", 0x0800_0024);
}

#[test]
fn b21_the_block_size_of_each_acknowledge_holds_for_the_next_sub_block() {
    let mut bench = Bench::node(4);
    let text = bench.read(0x2001, 0);
    bench.send("604: A4 01 20 00 01");
    bench.expect("584: C6 01 20 00 40");
    bench.send("604: A3");
    let mut segments = text.chunks(7);
    for (size, next) in [(1_u8, 3_u8), (3, 2), (2, 127), (4, 0)] {
        for number in 1..=size {
            let data = segments.next().unwrap();
            let is_last = segments.len() == 0;
            let hex: Vec<String> = data.iter().map(|byte| format!("{byte:02X}")).collect();
            let command = number | u8::from(is_last) << 7;
            bench.expect(&format!("584: {command:02X} {}", hex.join(" ")));
        }
        bench.silence(20);
        if next > 0 {
            bench.send(&format!("604: A2 {size:02X} {next:02X}"));
        }
    }
    bench.send("604: A2 04 04");
    // 64 bytes: the last segment carries one, six are unused.
    let crc = tests::crc(&text).to_le_bytes();
    bench.expect(&format!("584: D9 {:02X} {:02X}", crc[0], crc[1]));
    bench.send("604: A1");
    bench.silence(2_000);
}

#[test]
fn b22_a_multiple_of_seven_bytes_leaves_nothing_unused() {
    let mut bench = Bench::node(4);
    bench.send("604: A4 10 20 00 7F");
    bench.expect("584: C6 10 20 00 0E");
    bench.send("604: A3");
    bench.expect("584: 01 41 42 43 44 45 46 47");
    bench.expect("584: 82 48 49 4A 4B 4C 4D 4E");
    bench.send("604: A2 02 7F");
    bench.expect("584: C1 D6 38");
    bench.send("604: A1");
    bench.silence(2_000);
}

#[test]
fn b23_what_was_not_acknowledged_is_sent_again_from_number_1() {
    let mut bench = Bench::node(4);
    bench.send("604: A4 11 20 00 03");
    bench.expect("584: C6 11 20 00 0F");
    bench.send("604: A3");
    bench.expect("584: 01 41 42 43 44 45 46 47");
    bench.expect("584: 02 48 49 4A 4B 4C 4D 4E");
    bench.expect("584: 83 4F");
    bench.send("604: A2 01 03");
    bench.expect("584: 01 48 49 4A 4B 4C 4D 4E");
    bench.expect("584: 82 4F");
    bench.send("604: A2 00 01");
    bench.expect("584: 01 48 49 4A 4B 4C 4D 4E");
    bench.silence(20);
    bench.send("604: A2 01 01");
    bench.expect("584: 81 4F");
    bench.send("604: A2 01 01");
    let crc = tests::crc(b"ABCDEFGHIJKLMNO").to_le_bytes();
    bench.expect(&format!("584: D9 {:02X} {:02X}", crc[0], crc[1]));
    bench.send("604: A1");
    bench.silence(2_000);
}

#[test]
fn b25_a_short_value_goes_by_the_shorter_protocol() {
    let mut bench = Bench::node(4);
    bench.send("604: A0 18 10 01 01 14");
    bench.expect("584: 43 18 10 01 44 33 22 11");
    bench.silence(2_000);
    bench.send("604: A4 10 20 00 7F 14");
    bench.expect("584: 41 10 20 00 0E");
    bench.send("604: 60");
    bench.expect("584: 00 41 42 43 44 45 46 47");
    bench.send("604: 70");
    bench.expect("584: 11 48 49 4A 4B 4C 4D 4E");
    // One byte more than the threshold: a block after all.
    bench.send("604: A4 10 20 00 7F 0D");
    bench.expect("584: C6 10 20 00 0E");
}

#[test]
fn b26_a_client_that_falls_silent_in_an_upload_is_timed_out() {
    let gone = "584: 80 18 10 01 00 00 04 05";
    let mut bench = Bench::node(4);
    begun(&mut bench);
    bench.silence(990);
    bench.expect(gone);

    begun(&mut bench);
    bench.send("604: A3");
    bench.expect("584: 81 44 33 22 11");
    bench.silence(990);
    bench.expect(gone);

    begun(&mut bench);
    bench.send("604: A3");
    bench.expect("584: 81 44 33 22 11");
    bench.send("604: A2 01 14");
    bench.expect("584: CD ..");
    bench.silence(990);
    bench.expect(gone);

    bench.send("604: 40 00 10 00");
    bench.expect("584: 43 00 10 00 ..");
}

#[test]
fn b28_a_request_right_after_the_end_is_served() {
    let mut bench = Bench::node(4);
    begun(&mut bench);
    bench.send("604: A3");
    bench.expect("584: 81 44 33 22 11");
    bench.send("604: A2 01 14");
    bench.expect("584: CD ..");
    bench.queue("604: A1");
    bench.queue("604: 40 00 10 00");
    bench.expect("584: 43 00 10 00 ..");
    bench.silence(2_000);
}

#[test]
fn an_upload_gives_way_to_a_new_request() {
    let mut bench = Bench::node(4);
    bench.send("604: A4 01 20 00 01");
    bench.expect("584: C6 01 20 00 40");
    bench.send("604: A3");
    bench.expect("584: 01 41 42 43 44 45 46 47");
    bench.send("604: 40 00 10 00");
    bench.expect("584: 43 00 10 00 ..");
    bench.silence(2_000);
}
