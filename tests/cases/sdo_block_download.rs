//! Block downloads: the client sends sub-blocks of up to 127 segments, the server acknowledges each sub-block. The object is
//! 2012h, a block of up to 128 bytes; the data mostly the letters A to T, whose CRC is 1034h.

use tests::Bench;

/// A download of the letters A to T is open, nothing of it is sent.
fn begun() -> Bench {
    let mut bench = Bench::node(4);
    bench.send("604: C6 12 20 00 14");
    bench.expect("584: A4 12 20 00 7F");
    bench
}

/// The next frame within so many milliseconds.
fn soon(bench: &mut Bench, milliseconds: u64) -> String {
    let frame = bench.next(canopen::Duration::millis(milliseconds));
    frame.map_or("nothing".into(), |frame| tests::notation::show(&frame))
}

#[test]
fn b01_twenty_bytes_in_one_sub_block() {
    let mut bench = begun();
    bench.send("604: 01 41 42 43 44 45 46 47");
    bench.send("604: 02 48 49 4A 4B 4C 4D 4E");
    bench.silence(5);
    bench.send("604: 83 4F 50 51 52 53 54");
    bench.expect("584: A2 03 7F");
    bench.send("604: C5 34 10");
    bench.expect("584: A1");
    assert_eq!(bench.read(0x2012, 0), b"ABCDEFGHIJKLMNOPQRST");
}

#[test]
fn b02_a_client_without_crc_is_not_checked() {
    let mut bench = Bench::node(4);
    bench.write_u16(0x1017, 0, 60_000);
    bench.drain(5);
    bench.send("604: C2 17 10 00 02");
    bench.expect("584: A4 17 10 00 7F");
    bench.send("604: 81 00 00");
    bench.expect("584: A2 01 7F");
    bench.send("604: D5");
    bench.expect("584: A1");
    assert_eq!(bench.read_u16(0x1017, 0), 0);

    bench.send("604: C2 12 20 00 03");
    bench.expect("584: A4 12 20 00 7F");
    bench.send("604: 81 41 42 43");
    bench.expect("584: A2 01 7F");
    bench.send("604: D1 FF FF");
    bench.expect("584: A1");
    assert_eq!(bench.read(0x2012, 0), b"ABC");
}

#[test]
fn b08_a_lost_segment_is_sent_again() {
    let mut bench = begun();
    bench.send("604: 01 41 42 43 44 45 46 47");
    bench.send("604: 83 4F 50 51 52 53 54");
    bench.expect("584: A2 01 7F");
    bench.send("604: 01 48 49 4A 4B 4C 4D 4E");
    bench.send("604: 82 4F 50 51 52 53 54");
    bench.expect("584: A2 02 7F");
    bench.send("604: C5 34 10");
    bench.expect("584: A1");
    assert_eq!(bench.read(0x2012, 0), b"ABCDEFGHIJKLMNOPQRST");
}

#[test]
fn b09_without_its_first_segment_nothing_of_a_sub_block_counts() {
    let mut bench = begun();
    bench.send("604: 02 48 49 4A 4B 4C 4D 4E");
    bench.send("604: 83 4F 50 51 52 53 54");
    bench.expect("584: A2 00 7F");
    bench.send("604: 01 41 42 43 44 45 46 47");
    bench.send("604: 02 48 49 4A 4B 4C 4D 4E");
    bench.send("604: 83 4F 50 51 52 53 54");
    bench.expect("584: A2 03 7F");
    bench.send("604: C5 34 10");
    bench.expect("584: A1");
    assert_eq!(bench.read(0x2012, 0), b"ABCDEFGHIJKLMNOPQRST");
}

#[test]
fn b10_a_lost_end_of_a_sub_block_is_asked_for_before_the_time_out() {
    let mut bench = begun();
    bench.send("604: 01 41 42 43 44 45 46 47");
    bench.send("604: 02 48 49 4A 4B 4C 4D 4E");
    assert_eq!(soon(&mut bench, 990), "584 [8] A2 02 7F 00 00 00 00 00");
    bench.send("604: 81 4F 50 51 52 53 54");
    bench.expect("584: A2 01 7F");
    bench.send("604: C5 34 10");
    bench.expect("584: A1");
    assert_eq!(bench.read(0x2012, 0), b"ABCDEFGHIJKLMNOPQRST");

    let mut bench = begun();
    bench.send("604: 01 41 42 43 44 45 46 47");
    bench.send("604: 02 48 49 4A 4B 4C 4D 4E");
    let silent_since = bench.now();
    assert_eq!(soon(&mut bench, 990), "584 [8] A2 02 7F 00 00 00 00 00");
    assert_eq!(soon(&mut bench, 1_600), "584 [8] 80 12 20 00 00 00 04 05");
    assert!((bench.now() - silent_since).to_millis() >= 1_000);
    assert_eq!(bench.read(0x2012, 0), b"", "nothing was written");
}

#[test]
fn b11_a_doubled_segment_counts_once() {
    let mut bench = begun();
    bench.send("604: 01 41 42 43 44 45 46 47");
    bench.send("604: 01 41 42 43 44 45 46 47");
    bench.send("604: 02 48 49 4A 4B 4C 4D 4E");
    bench.send("604: 02 48 49 4A 4B 4C 4D 4E");
    bench.send("604: 83 4F 50 51 52 53 54");
    bench.expect("584: A2 03 7F");
    bench.send("604: C5 34 10");
    bench.expect("584: A1");
    assert_eq!(bench.read(0x2012, 0), b"ABCDEFGHIJKLMNOPQRST");
}

#[test]
fn b12_the_sequence_number_0_is_refused() {
    let mut bench = begun();
    bench.send("604: 00 41 42 43 44 45 46 47");
    bench.expect("584: 80 12 20 00 03 00 04 05");
    bench.send("604: 40 00 10 00");
    bench.expect("584: 43 00 10 00 ..");
}

#[test]
fn b13_an_abort_within_a_sub_block_ends_the_transfer() {
    let mut bench = begun();
    bench.send("604: 01 41 42 43 44 45 46 47");
    bench.send("604: 80 12 20 00 00 00 00 08");
    bench.silence(3_000);
    bench.send("604: 40 00 10 00");
    bench.expect("584: 43 00 10 00 ..");
    assert_eq!(bench.read(0x2012, 0), b"");
}

#[test]
fn b14_a_wrong_crc_is_refused_and_nothing_is_written() {
    let mut bench = begun();
    bench.send("604: 01 41 42 43 44 45 46 47");
    bench.send("604: 02 48 49 4A 4B 4C 4D 4E");
    bench.send("604: 83 4F 50 51 52 53 54");
    bench.expect("584: A2 03 7F");
    bench.send("604: C5 FF FF");
    bench.expect("584: 80 12 20 00 04 00 04 05");
    assert_eq!(bench.read(0x2012, 0), b"");
}

#[test]
fn b15_the_end_must_agree_with_the_size_that_was_indicated() {
    for end in ["604: C1 34 10", "604: C9 34 10", "604: D9 34 10"] {
        let mut bench = begun();
        bench.send("604: 01 41 42 43 44 45 46 47");
        bench.send("604: 02 48 49 4A 4B 4C 4D 4E");
        bench.send("604: 83 4F 50 51 52 53 54");
        bench.expect("584: A2 03 7F");
        bench.send(end);
        bench.expect("584: 80 12 20 00 10 00 07 06");
        assert_eq!(bench.read(0x2012, 0), b"");
    }
}

#[test]
fn b16_the_end_before_the_last_segment_is_refused() {
    let mut bench = begun();
    bench.send("604: 01 41 42 43 44 45 46 47");
    bench.send("604: C1 34 10");
    bench.expect("584: 80 12 20 00 01 00 04 05");
    bench.send("604: C1 34 10");
    bench.expect("584: 80 xx xx xx 01 00 04 05");
}

#[test]
fn b17_what_cannot_be_written_is_refused_at_once() {
    let mut bench = Bench::node(4);
    bench.refused("604: C6 00 10 00 04", 0x0601_0002);
    bench.refused("604: C6 FF 5F 00 04", 0x0602_0000);
    bench.refused("604: C6 18 10 09 04", 0x0609_0011);
}

#[test]
fn b18_a_size_that_does_not_fit_is_refused_at_once() {
    let mut bench = Bench::node(4);
    bench.refused("604: C6 00 20 00 05", 0x0607_0012);
    bench.refused("604: C6 00 20 00 03", 0x0607_0013);
    bench.refused("604: C6 12 20 00 81", 0x0607_0012);
    bench.refused("604: C6 12 20 00 00 00 00 80", 0x0607_0012);
}

#[test]
fn b19_no_bytes_at_all_empty_a_string_and_are_too_few_for_a_number() {
    let mut bench = Bench::node(4);
    bench.send("604: C6 01 20 00 00");
    bench.expect("584: A4 01 20 00 7F");
    bench.send("604: 81");
    bench.expect("584: A2 01 7F");
    bench.send("604: DD");
    bench.expect("584: A1");
    assert_eq!(bench.read(0x2001, 0), b"");
    bench.refused("604: C6 00 20 00 00", 0x0607_0013);
}

#[test]
fn b26_a_client_that_falls_silent_in_a_download_is_timed_out() {
    let gone = "584 [8] 80 12 20 00 00 00 04 05";
    // Nothing of the first sub-block came.
    let mut bench = begun();
    let answer = match soon(&mut bench, 2_000) {
        ack if ack.starts_with("584 [8] A2 00 7F") => soon(&mut bench, 2_000),
        other => other,
    };
    assert_eq!(answer, gone);

    // The end is missing.
    let mut bench = begun();
    bench.send("604: 01 41 42 43 44 45 46 47");
    bench.send("604: 02 48 49 4A 4B 4C 4D 4E");
    bench.send("604: 83 4F 50 51 52 53 54");
    bench.expect("584: A2 03 7F");
    bench.silence(990);
    assert_eq!(soon(&mut bench, 20), gone);
    bench.send("604: C5 34 10");
    bench.expect("584: 80 xx xx xx 01 00 04 05");
    assert_eq!(bench.read(0x2012, 0), b"");
}
