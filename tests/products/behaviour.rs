//! What the drives do in the way of their makers: faults, words, and habits of the drive, each beside a product without it.

use canopen::Frame;

use crate::bench::Bench;

const NODE: u8 = 4;

fn position(bench: &mut Bench) -> i32 {
    bench.read(NODE, 0x6064, 0) as i32
}

fn statusword(bench: &mut Bench) -> u16 {
    bench.read(NODE, 0x6041, 0) as u16
}

fn command(bench: &mut Bench, controlword: u16) {
    bench.write(NODE, 0x6040, 0, &controlword.to_le_bytes());
    bench.run(5);
}

/// A product whose motor is on, in this mode.
fn enabled(name: &str, mode: u8) -> Bench {
    let mut bench = Bench::node(name, NODE);
    bench.write(NODE, 0x6060, 0, &[mode]);
    bench.enable(NODE);
    bench
}

fn emergencies(bench: &mut Bench) -> Vec<[u8; 8]> {
    let own = |frame: &Frame| (frame.standard_id() == Some(0x084)).then(|| *frame.bytes());
    bench
        .sent
        .drain(..)
        .filter_map(|frame| own(&frame))
        .collect()
}

/// What happens when the power stage reports a fault.
fn faulted(bench: &mut Bench, cause: u16) -> Vec<[u8; 8]> {
    bench.sent.clear();
    bench.drive.plant_mut().fault = Some(cause);
    bench.run(30);
    let told = emergencies(bench);
    bench.drive.plant_mut().fault = None;
    bench.run(10);
    told
}

/// Each fault of the table of the S200: its code with the category in byte 3, then code 0 with what is wrong in all.
#[test]
fn the_s200_tells_of_each_fault_of_its_table() {
    let mut bench = Bench::node("s200", NODE);
    for (cause, code, category) in [
        (0x2330, 0x2330_u16, 1),
        (0x2380, 0x2380, 1),
        (0x3100, 0x3100, 1),
        (0x3210, 0x3110, 1),
        (0x3220, 0x3120, 1),
        (0x4110, 0x4110, 1),
        (0x4210, 0x4210, 1),
        (0x4310, 0x4310, 1),
        (0x5200, 0x5400, 1),
        (0x5380, 0x5380, 1),
        (0x5420, 0x5420, 1),
        (0x5530, 0x5530, 1),
        (0x6320, 0x6320, 3),
        (0x7111, 0x7111, 1),
        (0x7122, 0x7122, 1),
        (0x7303, 0x7303, 1),
        (0x7305, 0x7305, 1),
        (0x8053, 0x8053, 1),
        (0x8331, 0x8331, 1),
        (0x8480, 0x8480, 1),
        (0x8611, 0x8611, 2),
        (0x8612, 0xFF07, 2),
        (0xFF04, 0xFF04, 1),
        (0xFF06, 0xFF06, 2),
        (0xFF11, 0xFF11, 2),
        // Nothing but power ends it.
        (0x6100, 0xFF01, 4),
    ] {
        let told = faulted(&mut bench, cause);
        let [low, high] = code.to_le_bytes();
        let register = told[0][2];
        assert_eq!(register & 1, 1);
        assert_eq!(
            told,
            [
                [low, high, register, category, 0, 0, 0, 0],
                [0, 0, register, 0, 0, 0, 0, 0]
            ],
            "{cause:04X}h"
        );
        assert_eq!(bench.read(NODE, 0x1003, 1) as u16, code);
        // The error state shows in the manufacturer's status register.
        assert_eq!(bench.read(NODE, 0x1002, 0) >> 15 & 1, 1);
        command(&mut bench, 0x80);
        command(&mut bench, 0);
        // Some end with a cold start.
        bench.run(200);
        let state = if cause == 0x6100 { 0x08 } else { 0x40 };
        bench.wait_for_status(NODE, 0x4F, state, 100);
        assert_eq!(
            bench.read(NODE, 0x1002, 0) >> 15 & 1,
            u32::from(state == 0x08)
        );
    }
}

/// The LMD has one code for temperatures: what tells them apart is in the history, and in bytes 6 and 7.
#[test]
fn the_lmd_tells_a_hot_bridge_by_the_high_word_of_its_history() {
    let mut bench = Bench::node("lmd", NODE);
    let told = faulted(&mut bench, 0x4210);
    assert_eq!(told, [[0x10, 0x42, 0x09, 0, 0, 0, 0x08, 0]]);
    assert_eq!(bench.read(NODE, 0x1003, 1), 0x0008_4210);
    let mut bench = Bench::node("lmd", NODE);
    bench.sent.clear();
    bench.drive.plant_mut().temperature = 820;
    bench.run(2_000);
    assert_eq!(
        emergencies(&mut bench)[0],
        [0x10, 0x42, 0x09, 0, 0, 0, 0x16, 0]
    );
    assert_eq!(bench.read(NODE, 0x1003, 1), 0x0016_4210);
    assert_eq!(statusword(&mut bench) >> 7 & 1, 1, "the warning bit");
}

/// A short PDO: the LMD has its number in byte 5, the TC1 in byte 3.
#[test]
fn the_number_of_a_short_pdo_is_where_its_maker_has_it() {
    for (name, byte) in [("lmd", 5), ("tc1", 3)] {
        let mut bench = Bench::node(name, NODE);
        bench.send(&Frame::data_frame(0, &[1, NODE]));
        bench.run(20);
        bench.sent.clear();
        bench.send(&Frame::data_frame(0x204, &[6]));
        bench.run(20);
        let told = emergencies(&mut bench)[0];
        assert_eq!(told[..2], [0x10, 0x82], "{name}");
        assert_eq!(told[byte], 1, "{name}");
    }
}

/// The Nanotec has codes of its own list.
#[test]
fn the_nanotec_tells_faults_by_its_own_codes() {
    let mut bench = Bench::node("nanotec", NODE);
    for (cause, code) in [(0x3210_u16, 0x3200_u16), (0x4210, 0x4200), (0x2310, 0x2310)] {
        let told = faulted(&mut bench, cause);
        let [low, high] = code.to_le_bytes();
        assert_eq!(told[0][..2], [low, high]);
        assert_eq!(bench.read(NODE, 0x603F, 0) as u16, code);
        command(&mut bench, 0x80);
        command(&mut bench, 0);
    }
}

/// 1002h of the TC1: the statusword, and what the drive is doing.
#[test]
fn the_status_register_of_the_tc1_shows_the_drive() {
    let mut bench = Bench::node("tc1", NODE);
    bench.run(50);
    let word = |bench: &mut Bench| bench.read(NODE, 0x1002, 0);
    let shown = word(&mut bench);
    assert_eq!(shown as u16, statusword(&mut bench));
    assert_eq!(shown >> 16, 0x0104, "stationary, phase found");
    bench.write(NODE, 0x6060, 0, &[3]);
    bench.enable(NODE);
    assert_eq!(word(&mut bench) >> 17 & 1, 1, "motor on");
    bench.write(NODE, 0x60FF, 0, &4_000_i32.to_le_bytes());
    bench.run(500);
    assert_eq!(word(&mut bench) >> 24 & 1, 0, "it moves");
    bench.write(NODE, 0x60FF, 0, &0_i32.to_le_bytes());
    bench.run(1_000);
    assert_eq!(word(&mut bench) >> 24 & 1, 1);
    assert_eq!(word(&mut bench) >> 19 & 1, 0, "no home");
    bench.write(NODE, 0x6098, 0, &[35]);
    bench.write(NODE, 0x6060, 0, &[6]);
    bench.run(20);
    command(&mut bench, 0x1F);
    bench.wait_for_status(NODE, 0x1000, 0x1000, 1_000);
    assert_eq!(word(&mut bench) >> 19 & 1, 1, "home is known");
}

/// 1002h of the S200: motion, standstill, power, homing, initialisation.
#[test]
fn the_status_register_of_the_s200_shows_the_drive() {
    let mut bench = Bench::node("s200", NODE);
    bench.run(50);
    let bit = |bench: &mut Bench, bit: u32| bench.read(NODE, 0x1002, 0) >> bit & 1;
    assert_eq!(bit(&mut bench, 10), 1, "initialised");
    assert_eq!(
        (bit(&mut bench, 0), bit(&mut bench, 12), bit(&mut bench, 14)),
        (0, 1, 0)
    );
    bench.write(NODE, 0x6060, 0, &[3]);
    bench.enable(NODE);
    bench.write(NODE, 0x60FF, 0, &4_000_i32.to_le_bytes());
    bench.run(500);
    assert_eq!(
        (bit(&mut bench, 0), bit(&mut bench, 12), bit(&mut bench, 14)),
        (1, 0, 1)
    );
}

/// Set-points of profile position: the first is under way, the second waits; a third takes its place with a Nanotec, and is not taken
/// by a TC1.
#[test]
fn a_third_set_point_takes_the_place_of_the_second_or_is_not_taken() {
    for (name, expected) in [("nanotec", 7_000), ("tc1", 5_000)] {
        let mut bench = enabled(name, 1);
        for target in [3_000_i32, 5_000, 7_000] {
            bench.write(NODE, 0x607A, 0, &target.to_le_bytes());
            command(&mut bench, 0x1F);
            command(&mut bench, 0x0F);
        }
        bench.run(20_000);
        assert_eq!(position(&mut bench), expected, "{name}");
    }
}

/// Velocity mode of the Nanotec runs with 000Fh: the bits of the ramp mean nothing.
#[test]
fn the_velocity_of_a_nanotec_runs_with_000fh_and_halts_with_bit_8() {
    let mut bench = enabled("nanotec", 2);
    bench.write(NODE, 0x6042, 0, &500_i16.to_le_bytes());
    bench.run(2_000);
    let from = position(&mut bench);
    bench.run(1_000);
    let way = position(&mut bench) - from;
    assert!((450..=550).contains(&way), "{way}");
    command(&mut bench, 0x010F);
    bench.run(2_000);
    let stood = position(&mut bench);
    bench.run(200);
    assert_eq!(position(&mut bench), stood);
}

/// The remote bit of Nanotec and S200 stays; that of a TC1 tells whether the network commands it.
#[test]
fn the_remote_bit_stays_or_follows_the_network() {
    for (name, expected) in [("nanotec", 1), ("s200", 1)] {
        let mut bench = Bench::node(name, NODE);
        bench.send(&Frame::data_frame(0, &[2, NODE]));
        bench.run(50);
        let word = bench.drive.object(0x6041, 0).unwrap();
        assert_eq!(word[1] >> 1 & 1, expected, "{name}");
    }
    let mut bench = Bench::node("tc1", NODE);
    bench.send(&Frame::data_frame(0, &[2, NODE]));
    bench.run(50);
    assert_eq!(bench.drive.object(0x6041, 0).unwrap()[1] >> 1 & 1, 0);
}

/// Without motor supply an LMD is not ready, and becomes it when there is one; a TC1 waits with that for power.
#[test]
fn without_a_supply_the_lmd_is_not_ready() {
    for (name, state) in [("lmd", 0x40), ("tc1", 0x21)] {
        let mut bench = Bench::node(name, NODE);
        bench.drive.plant_mut().supply = false;
        bench.run(20);
        assert_eq!(statusword(&mut bench) >> 4 & 1, 0, "voltage enabled");
        command(&mut bench, 0x06);
        assert_eq!(statusword(&mut bench) & 0x6F, state, "{name}");
        bench.drive.plant_mut().supply = true;
        bench.wait_for_status(NODE, 0x6F, 0x21, 200);
    }
}

/// A motor that is pushed away is a fault of a TC1; an LMD tells of it by bit 13 and stays on.
#[test]
fn a_following_error_is_a_fault_or_a_bit() {
    for (name, is_fault) in [("lmd", false), ("nanotec", false), ("tc1", true)] {
        let mut bench = enabled(name, 1);
        bench.drive.plant_mut().encoder = true;
        bench.write(NODE, 0x6065, 0, &100_u32.to_le_bytes());
        bench.run(50);
        bench.drive.plant_mut().displace(1_000);
        bench.run(50);
        let word = statusword(&mut bench);
        assert_eq!(word >> 3 & 1 == 1, is_fault, "{name}: {word:04X}h");
        assert!(is_fault || word >> 13 & 1 == 1, "{name}: {word:04X}h");
        assert!(is_fault || word & 0x6F == 0x27, "{name}: {word:04X}h");
    }
}

/// Percent of the nominal current reach the driver of the motor, and the hold current once it stands.
#[test]
fn currents_are_percents_of_what_the_motor_takes() {
    let mut bench = Bench::node("lmd", NODE);
    bench.write(NODE, 0x2204, 0, &[50]);
    bench.write(NODE, 0x2205, 0, &[10]);
    bench.write(NODE, 0x2036, 0, &200_u16.to_le_bytes());
    bench.write(NODE, 0x6060, 0, &[1]);
    bench.enable(NODE);
    assert_eq!(bench.drive.plant_mut().current(), 1_500);
    bench.run(400);
    assert_eq!(bench.drive.plant_mut().current(), 300);
    let mut bench = Bench::node("nanotec", NODE);
    bench.write(NODE, 0x2004, 1, &[40]);
    bench.write(NODE, 0x2004, 2, &[20]);
    bench.write(NODE, 0x6060, 0, &[1]);
    bench.enable(NODE);
    assert_eq!(bench.drive.plant_mut().current(), 3_000);
    bench.run(400);
    assert_eq!(bench.drive.plant_mut().current(), 1_500);
}

/// A target beyond the software limits is cut, and bit 11 tells.
#[test]
fn a_target_beyond_the_software_limits_is_cut() {
    for (name, limits) in [("lmd", 0x2022), ("tc1", 0x607D), ("nanotec", 0x607D)] {
        let mut bench = Bench::node(name, NODE);
        if name == "lmd" {
            // Its mask leaves them out at first.
            bench.write(NODE, 0x2020, 2, &[0x0F]);
        }
        bench.write(NODE, limits, 1, &(-2_000_i32).to_le_bytes());
        bench.write(NODE, limits, 2, &2_000_i32.to_le_bytes());
        bench.write(NODE, 0x6060, 0, &[1]);
        bench.enable(NODE);
        bench.write(NODE, 0x607A, 0, &9_000_i32.to_le_bytes());
        command(&mut bench, 0x1F);
        bench.run(10_000);
        assert_eq!(position(&mut bench), 2_000, "{name}");
        assert_eq!(statusword(&mut bench) >> 11 & 1, 1, "{name}");
    }
}

/// Quick stop with option code 6 keeps the state until operation is enabled again.
#[test]
fn the_lmd_returns_from_quick_stop_to_operation_enabled() {
    let mut bench = enabled("lmd", 3);
    bench.write(NODE, 0x605A, 0, &6_i16.to_le_bytes());
    bench.write(NODE, 0x60FF, 0, &20_000_i32.to_le_bytes());
    bench.run(500);
    command(&mut bench, 0x0B);
    bench.run(1_000);
    assert_eq!(statusword(&mut bench) & 0x6F, 0x07, "quick stop active");
    let stood = position(&mut bench);
    command(&mut bench, 0x0F);
    bench.run(500);
    assert_eq!(statusword(&mut bench) & 0x6F, 0x27);
    assert_ne!(position(&mut bench), stood);
}

/// Quick stop of a Nanotec ends in switch on disabled by itself.
#[test]
fn the_quick_stop_of_a_nanotec_ends_by_itself() {
    let mut bench = enabled("nanotec", 2);
    bench.write(NODE, 0x6042, 0, &500_i16.to_le_bytes());
    bench.run(1_000);
    command(&mut bench, 0x0B);
    bench.wait_for_status(NODE, 0x4F, 0x40, 5_000);
}

/// Digital outputs follow 60FEh:1.
#[test]
fn outputs_follow_60feh() {
    for name in ["lmd", "nanotec"] {
        let mut bench = Bench::node(name, NODE);
        if name == "nanotec" {
            bench.write(NODE, 0x60FE, 2, &0_u32.to_le_bytes());
        }
        for levels in [0b001_u32, 0b110, 0] {
            bench.write(NODE, 0x60FE, 1, &(levels << 16).to_le_bytes());
            bench.run(20);
            assert_eq!(
                u32::from(bench.drive.plant_mut().outputs()) & 7,
                levels,
                "{name}"
            );
        }
    }
}

/// Node guarding that ends is warning n04 of the S200: bit 3 of its word of warnings.
#[test]
fn the_warnings_of_the_s200_tell_of_lost_guarding() {
    let mut bench = Bench::node("s200", NODE);
    bench.write(NODE, 0x100C, 0, &[50, 0]);
    bench.write(NODE, 0x100D, 0, &[2]);
    assert_eq!(bench.read(NODE, 0x2000, 0), 0);
    bench.send(&Frame::remote_frame(0x704, 0));
    bench.run(50);
    assert_eq!(bench.read(NODE, 0x2000, 0), 0);
    bench.sent.clear();
    bench.run(150);
    let told = emergencies(&mut bench);
    assert_eq!(told[0], [0x30, 0x81, 0x81, 2, 0, 0, 0, 0]);
    assert_eq!(bench.read(NODE, 0x2000, 0), 1 << 3);
}

/// Units of the user: the feed, and for the Nanotec the gear too.
#[test]
fn positions_are_in_units_of_feed_and_gear() {
    let mut bench = Bench::node("nanotec", NODE);
    bench.write(NODE, 0x6092, 1, &1_000_u32.to_le_bytes());
    bench.write(NODE, 0x6091, 1, &3_u32.to_le_bytes());
    bench.write(NODE, 0x6060, 0, &[1]);
    bench.enable(NODE);
    bench.write(NODE, 0x607A, 0, &500_i32.to_le_bytes());
    command(&mut bench, 0x1F);
    bench.run(20_000);
    assert_eq!(position(&mut bench), 500);
    assert_eq!(bench.drive.plant_mut().position(), 3_000);
    let mut bench = Bench::node("lmd", NODE);
    bench.write(NODE, 0x6092, 1, &25_600_u32.to_le_bytes());
    bench.write(NODE, 0x6060, 0, &[1]);
    bench.enable(NODE);
    bench.write(NODE, 0x607A, 0, &2_560_i32.to_le_bytes());
    command(&mut bench, 0x1F);
    bench.run(10_000);
    assert_eq!(bench.drive.plant_mut().position(), 5_120);
}
