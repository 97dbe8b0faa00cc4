//! Node-ID, bit rate, password and serial number as objects of the drive, and what must not change while the motor has power.

use canopen::settings::{Switches, Wish};
use canopen::{BitRate, BitTiming, NodeId};
use sim::drive::Setup;
use tests::DriveBench;
use tests::drive::SWITCH_ON_DISABLED;

/// An SDO that is answered, with the abort code if it is refused.
fn order(bench: &mut DriveBench, order: &str, answer: &str) {
    bench.queue(order);
    bench.drain_until(answer, 100);
}

/// Takes the power away and gives it back; the boot-up message comes from this node.
fn restart(bench: &mut DriveBench, node_id: u8) {
    bench.axis().power_cycle();
    bench.drain_until(&format!("{:03X} [1] 00", 0x700 + u16::from(node_id)), 100);
}

#[test]
fn a_node_id_that_is_written_counts_from_the_next_reset_and_is_stored() {
    let mut bench = DriveBench::booted(4);
    assert_eq!(bench.try_read(0x5FF0, 1), Ok(vec![4]));
    order(
        &mut bench,
        "604: 2F F0 5F 01 0B 00 00 00",
        "584: 60 F0 5F 01 00 00 00 00",
    );
    assert_eq!(bench.try_read(0x5FF0, 1), Ok(vec![11]));
    bench.send("000 [2] 82 04");
    bench.drain_until("70B [1] 00", 100);
    restart(&mut bench, 11);
}

#[test]
fn a_bit_rate_that_is_written_counts_from_the_next_power_on() {
    let mut bench = DriveBench::booted(4);
    order(
        &mut bench,
        "604: 2F F0 5F 02 03 00 00 00",
        "584: 60 F0 5F 02 00 00 00 00",
    );
    bench.send("000 [2] 81 04");
    bench.drain_until("704 [1] 00", 100);
    assert_eq!(
        bench.axis().device().node().settings().bit_rate,
        BitRate::Kbit1000
    );
    bench.axis().power_cycle();
    let settings = bench.axis().device().node().settings();
    assert_eq!(
        (settings.node_id.get(), settings.bit_rate),
        (4, BitRate::Kbit250)
    );
}

#[test]
fn what_is_no_node_id_or_bit_rate_is_refused() {
    let mut bench = DriveBench::booted(4);
    for number in ["00", "80", "FE"] {
        bench.refused(&format!("604: 2F F0 5F 01 {number} 00 00 00"), 0x0609_0030);
    }
    for index in ["05", "0A", "FF"] {
        bench.refused(&format!("604: 2F F0 5F 02 {index} 00 00 00"), 0x0609_0030);
    }
    bench.refused("604: 2F F0 5F 03 01 00 00 00", 0x0601_0002);
    assert_eq!(bench.try_read(0x5FF0, 1), Ok(vec![4]));
}

#[test]
fn flash_that_fails_is_told_to_who_writes_the_node_id() {
    let mut setup = Setup::with_node_id(1, 4);
    let mut flash = setup.store.release();
    flash.break_down();
    setup.store = flash.into_store();
    let mut bench = DriveBench::with(setup, 4);
    bench.refused("604: 2F F0 5F 01 0B 00 00 00", 0x0606_0000);
    // What was refused takes no effect, neither now nor later.
    assert_eq!(bench.try_read(0x5FF0, 1), Ok(vec![4]));
    bench.send("000 [2] 82 04");
    bench.drain_until("704 [1] 00", 100);
}

#[test]
fn lss_and_the_object_are_two_ways_to_the_same_settings() {
    let mut bench = DriveBench::booted(4);
    bench.send("7E5: 04 01");
    bench.send("7E5: 11 0C");
    bench.expect("7E4: 11 00");
    bench.send("7E5: 04 00");
    bench.drain(5);
    assert_eq!(bench.try_read(0x5FF0, 1), Ok(vec![12]));
    // What is stored now is both: the node-ID of LSS and the bit rate of the object.
    order(
        &mut bench,
        "604: 2F F0 5F 02 02 00 00 00",
        "584: 60 F0 5F 02 00 00 00 00",
    );
    bench.axis().power_cycle();
    let settings = bench.axis().device().node().settings();
    assert_eq!(
        (settings.node_id.get(), settings.bit_rate),
        (12, BitRate::Kbit500)
    );
}

#[test]
fn the_objects_tell_where_the_settings_come_from() {
    let setup = Setup {
        switches: Switches::ROTARY.wish(0x85),
        ..Setup::with_node_id(1, 9)
    };
    let mut bench = DriveBench::with(setup, 5);
    // Switches, and not what is stored; that is still there.
    assert_eq!(bench.try_read(0x5FF0, 3), Ok(vec![2]));
    assert_eq!(bench.try_read(0x5FF0, 4), Ok(vec![2]));
    assert_eq!(bench.try_read(0x5FF0, 1), Ok(vec![9]));
    let setup = Setup {
        build: Wish {
            node_id: NodeId::new(7),
            bit_timing: None,
        },
        switches: Switches::ROTARY.wish(0x05),
        ..Setup::with_node_id(1, 9)
    };
    let mut bench = DriveBench::with(setup, 7);
    assert_eq!(bench.try_read(0x5FF0, 3), Ok(vec![3]));
    assert_eq!(bench.try_read(0x5FF0, 4), Ok(vec![1]));
    bench.refused("607: 2F F0 5F 01 0B 00 00 00", 0x0800_0022);
    bench.send("7E5: 04 01");
    bench.send("7E5: 11 0C");
    bench.expect("7E4: 11 FF 01");
}

#[test]
fn a_position_of_the_switches_rescues_a_drive_at_a_bit_rate_that_nobody_knows() {
    let mut setup = Setup::with_node_id(1, 9);
    setup.settings = setup.settings.map(|settings| canopen::Configuration {
        bit_timing: BitTiming::Fixed(BitRate::Kbit20),
        ..settings
    });
    setup.switches = Switches::ROTARY.wish(0x80);
    // The bus runs at 1 Mbit/s, and there the drive is, with the node-ID that is stored.
    let mut bench = DriveBench::with(setup, 9);
    order(
        &mut bench,
        "609: 2F F0 5F 02 00 00 00 00",
        "589: 60 F0 5F 02 00 00 00 00",
    );
    restart(&mut bench, 9);
    assert_eq!(bench.try_read(0x5FF0, 2), Ok(vec![0]));
}

#[test]
fn what_must_not_change_is_locked_while_the_motor_has_power() {
    let mut bench = DriveBench::enabled(4);
    bench.write_u16(0x1800, 5, 0);
    bench.drain(20);
    bench.refused("604: 2F F0 5F 01 0B 00 00 00", 0x0800_0022);
    bench.command(0x00);
    bench.reaches(SWITCH_ON_DISABLED, 2_000);
    order(
        &mut bench,
        "604: 2F F0 5F 01 0B 00 00 00",
        "584: 60 F0 5F 01 00 00 00 00",
    );
}

const PASSWORD: &str = "604: 23 F1 5F 01 D2 04 00 00";
const TAKEN: &str = "584: 60 F1 5F 01 00 00 00 00";

#[test]
fn a_password_guards_the_settings_of_the_manufacturer() {
    let mut bench = DriveBench::booted(4);
    bench.write_u32(0x5FF1, 2, 1_234);
    bench.write_u16(0x2011, 0, 50);
    order(
        &mut bench,
        "604: 23 10 10 01 73 61 76 65",
        "584: 60 10 10 01 00 00 00 00",
    );
    restart(&mut bench, 4);
    assert_eq!(bench.try_read(0x5FF1, 3), Ok(vec![1]));
    bench.refused("604: 2B 11 20 00 0A 00 00 00", 0x0800_0022);
    bench.refused("604: 23 F1 5F 02 00 00 00 00", 0x0800_0022);
    // What is stored was loaded all the same, and what is no manufacturer's can be written.
    assert_eq!(bench.try_read(0x2011, 0), Ok(vec![50, 0]));
    bench.write_u32(0x6081, 0, 5);
    order(&mut bench, PASSWORD, TAKEN);
    assert_eq!(bench.try_read(0x5FF1, 3), Ok(vec![2]));
    bench.write_u16(0x2011, 0, 10);
    // Nobody reads it back.
    bench.refused("604: 40 F1 5F 01 00 00 00 00", 0x0601_0001);
    bench.refused("604: 40 F1 5F 02 00 00 00 00", 0x0601_0001);
    bench.send("000 [2] 81 04");
    bench.drain_until("704 [1] 00", 100);
    bench.refused("604: 2B 11 20 00 0A 00 00 00", 0x0800_0022);
}

#[test]
fn after_a_wrong_password_none_is_taken_for_a_second() {
    let mut bench = DriveBench::booted(4);
    bench.write_u32(0x5FF1, 2, 1_234);
    bench.refused("604: 23 F1 5F 01 D3 04 00 00", 0x0609_0030);
    assert_eq!(bench.try_read(0x5FF1, 3), Ok(vec![1]));
    bench.refused(PASSWORD, 0x0800_0022);
    bench.drain(1_000);
    order(&mut bench, PASSWORD, TAKEN);
}

/// Opens what production writes.
const PRODUCTION: &str = "604: 23 F1 5F 01 70 72 6F 64";
const SERIAL: &str = "604: 23 F2 5F 01 78 56 34 12";
const GIVEN: &str = "584: 60 F2 5F 01 00 00 00 00";

#[test]
fn production_writes_the_serial_number_once() {
    let mut bench = DriveBench::booted(4);
    assert_eq!(bench.read_u32(0x1018, 4), 1);
    bench.refused(SERIAL, 0x0800_0022);
    order(&mut bench, PRODUCTION, TAKEN);
    assert_eq!(bench.try_read(0x5FF1, 3), Ok(vec![3]));
    bench.refused("604: 23 F2 5F 01 00 00 00 00", 0x0609_0030);
    order(&mut bench, SERIAL, GIVEN);
    assert_eq!(bench.read_u32(0x5FF2, 1), 0x1234_5678);
    // That was all production had to do: a second number is refused at once, and so is the key.
    assert_eq!(bench.try_read(0x5FF1, 3), Ok(vec![0]));
    bench.refused("604: 23 F2 5F 01 79 56 34 12", 0x0800_0022);
    bench.refused(PRODUCTION, 0x0609_0030);
    assert_eq!(bench.read_u32(0x5FF2, 1), 0x1234_5678);
    restart(&mut bench, 4);
    assert_eq!(bench.read_u32(0x1018, 4), 0x1234_5678);
    assert_eq!(bench.read_u32(0x5FF2, 1), 0x1234_5678);
    bench.refused(PRODUCTION, 0x0609_0030);
    bench.refused(SERIAL, 0x0800_0022);
}

#[test]
fn a_serial_number_that_is_not_stored_is_not_shown_and_may_be_tried_again() {
    let mut setup = Setup::with_node_id(1, 4);
    let mut flash = setup.store.release();
    flash.break_down();
    setup.store = flash.into_store();
    let mut bench = DriveBench::with(setup, 4);
    order(&mut bench, PRODUCTION, TAKEN);
    for _ in 0..2 {
        bench.refused(SERIAL, 0x0606_0000);
        assert_eq!(bench.read_u32(0x5FF2, 1), 0);
        assert_eq!(bench.try_read(0x5FF1, 3), Ok(vec![3]));
    }
}

/// A drive with password 1234, locked by a wrong one, after the second in which none is taken.
fn locked() -> DriveBench {
    let mut bench = DriveBench::booted(4);
    bench.write_u32(0x5FF1, 2, 1_234);
    bench.refused("604: 23 F1 5F 01 D3 04 00 00", 0x0609_0030);
    bench.drain(1_000);
    bench
}

#[test]
fn production_opens_nothing_that_the_password_guards() {
    let mut bench = locked();
    order(&mut bench, PRODUCTION, TAKEN);
    bench.refused("604: 2B 11 20 00 0A 00 00 00", 0x0800_0022);
    bench.refused("604: 23 F1 5F 02 00 00 00 00", 0x0800_0022);
    bench.refused("604: 2F F0 5F 01 0B 00 00 00", 0x0800_0022);
    // Whoever has given both may do both.
    order(&mut bench, PASSWORD, TAKEN);
    bench.write_u16(0x2011, 0, 10);
    order(&mut bench, SERIAL, GIVEN);
    bench.write_u16(0x2011, 0, 20);
}

#[test]
fn a_password_guards_objects_of_any_length() {
    let mut bench = locked();
    bench.refused("604: 21 20 20 00 0A 00 00 00", 0x0800_0022);
    bench.refused("604: C2 20 20 00 0A 00 00 00", 0x0800_0022);
    order(&mut bench, PASSWORD, TAKEN);
    order(
        &mut bench,
        "604: 21 20 20 00 0A 00 00 00",
        "584: 60 20 20 00 00 00 00 00",
    );
}
