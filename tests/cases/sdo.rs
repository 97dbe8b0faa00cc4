//! Service data objects, expedited and segmented.

use tests::Bench;

#[test]
fn s01_a_u32_is_uploaded_expedited() {
    let mut bench = Bench::node(4);
    bench.send("604: 40 00 10 00");
    bench.expect("584: 43 00 10 00 ..");
}

#[test]
fn s02_unused_bytes_of_short_values_are_zero() {
    let mut bench = Bench::node(4);
    bench.send("604: 40 01 10 00");
    bench.expect("584: 4F 01 10 00 00");
    bench.send("604: 40 17 10 00");
    bench.expect("584: 4B 17 10 00 00 00");
}

#[test]
fn s03_a_constant_is_not_written() {
    let mut bench = Bench::node(4);
    bench.refused("604: 23 00 10 00 01 02 03 04", 0x0601_0002);
}

#[test]
fn s04_a_write_only_object_is_not_read() {
    let mut bench = Bench::node(4);
    bench.send("604: 2B 09 20 00 34 12");
    bench.expect("584: 60 09 20 00");
    bench.refused("604: 40 09 20 00", 0x0601_0001);
}

#[test]
fn s05_a_missing_sub_index_is_named() {
    Bench::node(4).refused("604: 40 00 10 05", 0x0609_0011);
}

#[test]
fn s06_a_missing_object_is_named() {
    Bench::node(4).refused("604: 40 04 10 00", 0x0602_0000);
}

#[test]
fn s07_an_unknown_command_is_refused() {
    Bench::node(4).refused("604: E0 00 10 00", 0x0504_0001);
}

#[test]
fn s08_four_bytes_are_too_many_for_a_u8() {
    let mut bench = Bench::node(4);
    bench.refused("604: 23 08 20 00 0A 00 00 00", 0x0607_0012);
}

#[test]
fn s09_one_byte_is_too_few_for_a_u32() {
    Bench::node(4).refused("604: 2F 05 10 00 80", 0x0607_0013);
}

#[test]
fn s10_the_error_history_takes_only_zero() {
    Bench::node(4).refused("604: 2F 03 10 00 FF", 0x0609_0030);
}

#[test]
fn s11_the_server_parameters_show_the_identifiers_and_are_read_only() {
    let mut bench = Bench::node(4);
    assert_eq!(bench.read_u32(0x1200, 1), 0x604);
    assert_eq!(bench.read_u32(0x1200, 2), 0x584);
    bench.refused("604: 23 00 12 01 05 06 00 00", 0x0601_0002);
}

#[test]
fn s12_an_expedited_download_without_size_takes_the_size_of_the_object() {
    let mut bench = Bench::node(4);
    bench.send("604: 22 17 10 00 E8 03 00 00");
    bench.expect("584: 60 17 10 00");
    assert_eq!(bench.read_u16(0x1017, 0), 1000);
}

#[test]
fn s13_two_bytes_by_segments() {
    let mut bench = Bench::node(4);
    bench.write_u16(0x1017, 0, 60_000);
    bench.drain(10);
    bench.send("604: 21 17 10 00 02 00 00 00");
    bench.expect("584: 60 17 10 00");
    bench.send("604: 0B 00 00");
    bench.expect("584: 20");
    assert_eq!(bench.read_u16(0x1017, 0), 0);
}

#[test]
fn s14_a_string_by_segments() {
    let mut bench = Bench::node(4);
    let name = bench.read(0x2001, 0);
    assert_eq!(name.len(), 64);
    bench.send("604: 40 01 20 00");
    bench.expect("584: 41 01 20 00 40");
    for (segment, chunk) in name.chunks(7).enumerate() {
        let toggle = if segment % 2 == 0 { 0x60 } else { 0x70 };
        bench.send(&format!("604: {toggle:02X}"));
        let last = segment == 9;
        let command = (toggle & 0x10) | ((7 - chunk.len() as u8) << 1) | u8::from(last);
        let bytes: Vec<String> = chunk.iter().map(|byte| format!("{byte:02X}")).collect();
        bench.expect(&format!("584: {command:02X} {}", bytes.join(" ")));
    }
}

#[test]
fn s15_a_wrong_toggle_in_an_upload_is_refused() {
    let mut bench = Bench::node(4);
    bench.send("604: 40 01 20 00");
    bench.expect("584: 41 01 20 00 40");
    bench.send("604: 70");
    bench.expect("584: 80 01 20 00 00 00 03 05");
}

#[test]
fn s16_a_wrong_toggle_in_a_download_is_refused() {
    let mut bench = Bench::node(4);
    bench.send("604: 21 17 10 00 02");
    bench.expect("584: 60 17 10 00");
    bench.send("604: 1B 01 02");
    bench.expect("584: 80 17 10 00 00 00 03 05");
}

#[test]
fn s17_a_segmented_download_without_size_is_taken() {
    let mut bench = Bench::node(4);
    bench.send("604: 20 17 10 00");
    bench.expect("584: 60 17 10 00");
    bench.send("604: 0B 10 27");
    bench.expect("584: 20");
    assert_eq!(bench.read_u16(0x1017, 0), 10_000);
}

#[test]
fn s18_more_bytes_than_indicated_are_refused() {
    let mut bench = Bench::node(4);
    bench.send("604: 21 17 10 00 02");
    bench.expect("584: 60 17 10 00");
    bench.send("604: 09 01 02 03");
    bench.expect("584: 80 17 10 00 12 00 07 06");
}

#[test]
fn s19_fewer_bytes_than_indicated_are_refused() {
    let mut bench = Bench::node(4);
    bench.send("604: 21 00 20 00 04");
    bench.expect("584: 60 00 20 00");
    bench.send("604: 0B 01 02");
    bench.expect("584: 80 00 20 00 13 00 07 06");
    assert_eq!(bench.read_u32(0x2000, 0), 0);
}

#[test]
fn s20_no_bytes_at_all_for_a_u8_are_refused() {
    let mut bench = Bench::node(4);
    bench.send("604: 20 00 16 00");
    bench.expect("584: 60 00 16 00");
    bench.send("604: 0F");
    bench.expect("584: 80 00 16 00 13 00 07 06");
}

#[test]
fn s21_an_empty_string_goes_down_and_up() {
    let mut bench = Bench::node(4);
    bench.send("604: 21 01 20 00");
    bench.expect("584: 60 01 20 00");
    bench.send("604: 0F");
    bench.expect("584: 20");
    bench.send("604: 40 01 20 00");
    bench.expect("584: 41 01 20 00 00 00 00 00");
    bench.send("604: 60");
    bench.expect("584: 0F");
}

#[test]
fn s22_the_last_segment_tells_what_is_unused() {
    let mut bench = Bench::node(4);
    for (sub_index, length) in [6_usize, 7, 8, 13, 14, 15].into_iter().enumerate() {
        let index = 0x200C + sub_index;
        bench.send(&format!("604: 40 {:02X} 20 00", index & 0xFF));
        bench.expect(&format!("584: 41 {:02X} 20 00 {length:02X}", index & 0xFF));
        let segments = length.div_ceil(7);
        for segment in 0..segments {
            bench.send(if segment % 2 == 0 {
                "604: 60"
            } else {
                "604: 70"
            });
            let answer = bench.expect("584: ..");
            let last = segment + 1 == segments;
            let unused = if last { segments * 7 - length } else { 0 };
            let toggle = (segment % 2 == 1) as u8;
            assert_eq!(
                answer.payload()[0],
                toggle << 4 | (unused as u8) << 1 | u8::from(last),
                "string of {length}"
            );
        }
    }
}

#[test]
fn s23_a_new_request_drops_the_open_transfer() {
    let mut bench = Bench::node(4);
    bench.send("604: 40 01 20 00");
    bench.expect("584: 41 01 20 00 40");
    bench.send("604: 40 00 10 00");
    bench.expect("584: 43 00 10 00 ..");
    bench.silence(2_000);
}

#[test]
fn s24_a_segment_request_out_of_the_blue_is_refused() {
    let mut bench = Bench::node(4);
    bench.send("604: 60");
    bench.expect("584: 80 00 00 00 01 00 04 05");
}

#[test]
fn s25_an_abort_is_never_answered() {
    let mut bench = Bench::node(4);
    bench.send("604: 80 00 10 00 00 00 00 08");
    bench.silence(100);
    bench.send("604: 40 01 20 00");
    bench.expect("584: 41 01 20 00 40");
    bench.send("604: 80 01 20 00 00 00 00 08");
    bench.silence(2_000);
    bench.send("604: 40 00 10 00");
    bench.expect("584: 43 00 10 00 ..");
}

#[test]
fn s26_a_silent_client_is_timed_out_after_a_second() {
    let mut bench = Bench::node(4);
    bench.send("604: 21 17 10 00 02");
    bench.expect("584: 60 17 10 00");
    bench.silence(990);
    bench.expect("584: 80 17 10 00 00 00 04 05");
    bench.send("604: 0B");
    bench.expect("584: 80 xx xx xx 01 00 04 05");
}

#[test]
fn s27_the_time_out_counts_from_the_last_frame() {
    let mut bench = Bench::node(4);
    bench.send("604: 21 01 20 00 15");
    bench.expect("584: 60 01 20 00");
    for (request, answer) in [
        ("604: 00 41 42 43 44 45 46 47", "584: 20"),
        ("604: 10 48 49 4A 4B 4C 4D 4E", "584: 30"),
        ("604: 01 4F 50 51 52 53 54 55", "584: 20"),
    ] {
        bench.silence(900);
        bench.send(request);
        bench.expect(answer);
    }
    assert_eq!(bench.read(0x2001, 0), b"ABCDEFGHIJKLMNOPQRSTU");
}

#[test]
fn s28_a_short_request_is_not_answered() {
    let mut bench = Bench::node(4);
    bench.send("604 [4] 40 00 10 00");
    bench.silence(100);
}

#[test]
fn s29_foreign_extended_and_remote_requests_are_not_answered() {
    let mut bench = Bench::node(4);
    for request in ["605: 40 00 10 00", "00000604: 40 00 10 00", "604 [8] rtr"] {
        bench.send(request);
        bench.silence(100);
    }
}

#[test]
fn s30_limits_of_the_data_sheet_are_kept() {
    let mut bench = Bench::node(4);
    bench.refused("604: 2F 08 20 00 09", 0x0609_0032);
    bench.refused("604: 2F 08 20 00 15", 0x0609_0031);
    bench.send("604: 2F 08 20 00 14");
    bench.expect("584: 60 08 20 00");
}

#[test]
fn s32_an_empty_history_has_no_data() {
    Bench::node(4).refused("604: 40 03 10 01", 0x0800_0024);
}

#[test]
fn s33_an_aborted_download_leaves_the_old_value_whole() {
    let mut bench = Bench::node(4);
    bench.write(0x2007, 0, &0x0102_0304_0506_0708_u64.to_le_bytes());
    bench.send("604: 21 07 20 00 08");
    bench.expect("584: 60 07 20 00");
    bench.send("604: 00 FF FF FF FF FF FF FF");
    bench.expect("584: 20");
    bench.send("604: 80 07 20 00 00 00 00 08");
    assert_eq!(
        bench.read(0x2007, 0),
        0x0102_0304_0506_0708_u64.to_le_bytes()
    );
}

#[test]
fn s34_an_upload_shows_the_value_as_it_was_when_it_began() {
    let mut bench = Bench::node(4);
    bench.start();
    bench.write(0x2007, 0, &[0x11; 8]);
    bench.send("604: 40 07 20 00");
    bench.expect("584: 41 07 20 00 08");
    bench.send("604: 60");
    bench.expect("584: 00 11 11 11 11 11 11 11");
    bench.change(|dictionary| dictionary.set_wide_number(0x2222_2222_2222_2222));
    bench.send("604: 70");
    bench.expect("584: 1D 11");
}

#[test]
fn s36_two_requests_at_once_are_both_answered_in_order() {
    let mut bench = Bench::node(4);
    bench.queue("604: 40 00 10 00");
    bench.queue("604: 40 17 10 00");
    bench.expect("584: 43 00 10 00 ..");
    bench.expect("584: 4B 17 10 00");
    bench.silence(100);
}

#[test]
fn s37_a_string_that_is_too_long_is_refused_at_once() {
    Bench::node(4).refused("604: 21 01 20 00 41 00 00 00", 0x0607_0012);
}

#[test]
fn s41_restricted_identifiers_are_refused_everywhere() {
    let mut bench = Bench::node(4);
    for (index, sub) in [(0x1005_u16, 0_u8), (0x1014, 0), (0x1400, 1), (0x1800, 1)] {
        if index != 0x1005 {
            let old = bench.read_u32(index, sub);
            bench.write_u32(index, sub, old | 0x8000_0000);
        }
        for cob_id in [
            0x000_u32, 0x001, 0x07F, 0x101, 0x180, 0x581, 0x5FF, 0x601, 0x67F, 0x6E0, 0x6FF, 0x701,
            0x77F, 0x780, 0x7FF,
        ] {
            let [low, high] = index.to_le_bytes();
            let [a, b, ..] = cob_id.to_le_bytes();
            bench.refused(
                &format!("604: 23 {low:02X} {high:02X} {sub:02X} {a:02X} {b:02X}"),
                0x0609_0030,
            );
        }
    }
}
