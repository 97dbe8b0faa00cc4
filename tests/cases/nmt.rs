//! Network management and boot-up.

use tests::Bench;

#[test]
fn n01_boot_up_is_the_first_frame_and_comes_once() {
    let mut bench = Bench::powered(4);
    bench.expect("704 [1] 00");
    bench.silence(5_000);
}

#[test]
fn n02_nothing_is_sent_by_itself_in_pre_operational() {
    let mut bench = Bench::node(4);
    bench.write_u16(0x1017, 0, 0);
    bench.silence(5_000);
}

#[test]
fn n03_start_sends_each_event_driven_tpdo_once() {
    let mut bench = Bench::node(4);
    bench.send("000 [2] 01 04");
    bench.expect("184 ..");
    bench.silence(1_000);
}

#[test]
fn n04_broadcast_starts_too() {
    let mut bench = Bench::node(4);
    bench.send("000 [2] 01 00");
    bench.expect("184 ..");
}

#[test]
fn n05_commands_for_other_nodes_change_nothing() {
    let mut bench = Bench::node(4);
    for command in ["000 [2] 01 05", "000 [2] 02 0B"] {
        bench.send(command);
        bench.silence(100);
    }
    assert_eq!(bench.state_in_heartbeat(), 0x7F);
}

#[test]
fn n06_only_two_bytes_make_a_command() {
    let mut bench = Bench::node(4);
    for command in ["000 [1] 01", "000 [0]", "000 [8] 01 04"] {
        bench.send(command);
        bench.silence(100);
    }
    assert_eq!(bench.state_in_heartbeat(), 0x7F);
}

#[test]
fn n07_unknown_commands_and_impossible_nodes_are_ignored() {
    let mut bench = Bench::node(4);
    for command in ["000 [2] 77 04", "000 [2] 01 84"] {
        bench.send(command);
        bench.silence(100);
    }
    assert_eq!(bench.state_in_heartbeat(), 0x7F);
}

#[test]
fn n08_stopped_answers_no_sdo_but_beats() {
    let mut bench = Bench::node(4);
    bench.write_u16(0x1017, 0, 100);
    bench.drain(50);
    bench.send("000 [2] 02 04");
    bench.drain(5);
    bench.send("604: 40 00 10 00");
    bench.expect("704 [1] 04");
    bench.expect("704 [1] 04");
}

#[test]
fn n09_stopped_takes_no_rpdo_and_answers_lss() {
    let mut bench = Bench::node(4);
    bench.write_u32(0x1800, 1, 0xC000_0184);
    bench.write_u8(0x1800, 2, 1);
    bench.write_u32(0x1800, 1, 0x4000_0184);
    bench.start();
    bench.send("000 [2] 02 04");
    bench.send("204: 11 22 33 44 55 66 77 88");
    bench.send("080 [0]");
    bench.silence(100);
    bench.send("7E5: 04 01");
    bench.send("7E5: 5E");
    bench.expect("7E4: 5E 04");
    bench.send("7E5: 04 00");
    bench.send("000 [2] 80 04");
    bench.drain(10);
    assert_eq!(bench.read_u32(0x2003, 0), 0);
}

#[test]
fn n10_reset_node_boots_with_power_on_values() {
    let mut bench = Bench::node(4);
    bench.write_u32(0x2000, 0, 0xCAFE_F00D);
    bench.write_u16(0x1017, 0, 50);
    bench.drain(20);
    bench.send("000 [2] 81 04");
    bench.expect("704 [1] 00");
    bench.silence(500);
    assert_eq!(bench.read_u32(0x2000, 0), 0);
    assert_eq!(bench.read_u16(0x1017, 0), 0);
}

#[test]
fn n11_reset_communication_keeps_the_application_objects() {
    let mut bench = Bench::node(4);
    bench.write_u32(0x2000, 0, 0xCAFE_F00D);
    bench.write_u16(0x1017, 0, 50);
    bench.drain(20);
    bench.send("000 [2] 82 04");
    bench.expect("704 [1] 00");
    bench.silence(500);
    assert_eq!(bench.read_u32(0x2000, 0), 0xCAFE_F00D);
    assert_eq!(bench.read_u16(0x1017, 0), 0);
}

#[test]
fn n12_two_commands_back_to_back_are_both_executed_in_order() {
    let mut bench = Bench::node(4);
    bench.queue("000 [2] 02 04");
    bench.queue("000 [2] 01 04");
    bench.expect("184 ..");
    assert_eq!(bench.state_in_heartbeat(), 0x05);
}

#[test]
fn n13_reset_communication_drops_an_open_transfer() {
    let mut bench = Bench::node(4);
    bench.send("604: 21 17 10 00 02");
    bench.expect("584: 60 17 10 00");
    bench.send("000 [2] 82 04");
    bench.expect("704 [1] 00");
    bench.silence(2_000);
    bench.send("604: 40 17 10 00");
    bench.expect("584: 4B 17 10 00");
}

#[test]
fn n14_extended_and_remote_frames_with_identifier_0_are_ignored() {
    let mut bench = Bench::node(4);
    bench.send("00000000 [2] 01 04");
    bench.send("000 [2] rtr");
    bench.silence(100);
    assert_eq!(bench.state_in_heartbeat(), 0x7F);
}

#[test]
fn n15_start_while_operational_repeats_nothing() {
    let mut bench = Bench::node(4);
    bench.start();
    bench.send("000 [2] 01 04");
    bench.silence(500);
}

#[test]
fn n19_random_values_in_the_communication_area_do_not_survive_a_reset() {
    let mut bench = Bench::node(4);
    let before: Vec<_> = bench.communication_area();
    let mut random = 0x2545_F491_u32;
    for (index, sub, bytes) in &before {
        for _ in 0..4 {
            let mut value = vec![0; bytes.len()];
            for byte in &mut value {
                random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                *byte = (random >> 24) as u8;
            }
            let _ = bench.try_write(*index, *sub, &value);
        }
    }
    bench.drain(1_000);
    bench.send("000 [2] 81 04");
    bench.expect("704 [1] 00");
    bench.silence(1_000);
    assert_eq!(bench.communication_area(), before);
}
