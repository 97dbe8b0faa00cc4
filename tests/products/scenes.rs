//! What stands before the worked sequences: in which state the drive is, and what happens around it that no frame tells.

use canopen::Frame;
use sim::drive::Setup;

use crate::bench::Bench;
use crate::steer;

/// Sequences that do not play yet, or never will, and why.
pub const NOT_YET: &[(&str, &str, &str)] = &[
    (
        "lmd",
        "emcy-figure",
        "a picture of any device: 2212h is no code of the LMD. The bytes of its own: `the_number_of_a_short_pdo_is_where_its_maker_has_it`",
    ),
    (
        "tc1",
        "rpdo-principle",
        "a picture: the TC1 has none of its objects. The same with objects that it has: rpdo-remap",
    ),
];

/// Lines in which a manual is wrong or shows any values: product, sequence, step, what is played, why.
pub const PUT_RIGHT: &[(&str, &str, u64, &str, &str)] = &[
    (
        "lmd",
        "sdo-read-device-type-node1",
        1,
        "43 00 10 00 92 01 44 00",
        "a picture of any device; 1000h of the LMD is 00440192h",
    ),
    (
        "lmd",
        "pdo-mapping-figure",
        1,
        "?? ?? ?? ?? ?? ??",
        "any statusword and position",
    ),
    (
        "s200",
        "S02-nodeguard",
        8,
        "4F 0D 10 00 0F 00 00 00",
        "the manual reads 0 where it has written 15",
    ),
    (
        "s200",
        "S02-nodeguard",
        13,
        "30 81 ?? ?? ?? ?? ?? ??",
        "the manual has a byte before the 81h of the code 8130h",
    ),
    (
        "s200",
        "S14-emcy",
        1,
        "10 43 09 01 00 00 00 00",
        "seven bytes are printed, without the generic bit that each error sets and the category 1 of this one",
    ),
    (
        "s200",
        "S14-emcy",
        2,
        "00 00 09 00 00 00 00 00",
        "seven bytes are printed, without the generic bit",
    ),
    (
        "s200",
        "S09-jog-pdo",
        40,
        "?? ?? ?? ?? ?? ?? ?? ??",
        "any position and velocity",
    ),
];

/// The product in the scene of a sequence.
pub fn set(product: &str, sequence: &str) -> Bench {
    match product {
        "lmd" => lmd(sequence),
        "nanotec" => nanotec(sequence),
        "s200" => s200(sequence),
        _ => tc1(sequence),
    }
}

fn lmd(sequence: &str) -> Bench {
    // As it leaves the factory: node 41h.
    let mut bench = Bench::new("lmd", Setup::unconfigured(1));
    match sequence {
        "node-guarding" => nmt(&mut bench, 1, 0x41),
        "heartbeat" => {
            nmt(&mut bench, 1, 0x41);
            bench.write(0x41, 0x1017, 0, &[100, 0]);
            bench.sent.clear();
        }
        "profile-torque" => {
            bench = steer::servo_node("lmd", "nema23", 0x41);
            bench.enable(0x41);
        }
        "sdo-read-device-type-node1" => {
            bench = Bench::node("lmd", 1);
            bench.send(&Frame::full(0x601, [0x40, 0x00, 0x10, 0, 0, 0, 0, 0]));
        }
        "pdo-mapping-figure" => {
            bench.send(&Frame::data_frame(0, &[1, 0x41]));
        }
        _ => {}
    }
    bench
}

fn nanotec(sequence: &str) -> Bench {
    let is_34 = sequence.ends_with("node34");
    let node = if is_34 { 34 } else { 1 };
    let mut bench = Bench::node("nanotec", node);
    match sequence {
        "nmt-status-rtr-node34" => nmt(&mut bench, 1, 34),
        "select-pp-node34" => bench.enable(34),
        "start-travel-node34" => {
            bench.write(34, 0x6060, 0, &[1]);
            bench.enable(34);
        }
        _ => {}
    }
    bench
}

fn s200(sequence: &str) -> Bench {
    let node = match &sequence[..3] {
        "S01" | "S14" => 1,
        "S02" => 2,
        _ => 3,
    };
    let mut bench = Bench::node("s200", node);
    if matches!(&sequence[..3], "S08" | "S10") {
        store_task_3(&mut bench);
    }
    bench
}

/// Motion task 3 of the S200 is 5000 counts further, and the axis is homed.
fn store_task_3(bench: &mut Bench) {
    bench.write(3, 0x6098, 0, &[35]);
    bench.write(3, 0x6060, 0, &[6]);
    bench.enable(3);
    bench.write(3, 0x6040, 0, &[0x1F, 0]);
    bench.wait_for_status(3, 0x1400, 0x1400, 1_000);
    bench.write(3, 0x6040, 0, &[0, 0]);
    bench.wait_for_status(3, 0x6F, 0x40, 1_000);
    for (index, value) in [(0x35BE, 5_000_u32), (0x35BF, 100_000), (0x35B9, 1)] {
        bench.write(3, index, 1, &value.to_le_bytes());
    }
    bench.write(3, 0x2082, 0, &0x0003_0000_u32.to_le_bytes());
    bench.sent.clear();
}

fn tc1(sequence: &str) -> Bench {
    let mut bench = Bench::node("tc1", 1);
    match sequence {
        "nmt-stop" | "rtr-ignored" | "pdo-default" | "rpdo-disabled-default" | "rpdo-too-long" => {
            nmt(&mut bench, 1, 1);
        }
        "heartbeat" => {
            bench.write(1, 0x1017, 0, &[100, 0]);
            bench.write(1, 0x1010, 1, b"save");
            bench.send(&Frame::data_frame(0, &[0x81, 1]));
        }
        "sdo-client-abort" => {
            bench.sdo(1, [0x40, 0x08, 0x10, 0, 0, 0, 0, 0]);
        }
        "store-failure" => bench.drive.with_flash(&mut |flash| flash.break_down()),
        "sync-counter" | "sync-bad-length" => bench.write(1, 0x1019, 0, &[240]),
        "sync-locked" => {
            bench.write(1, 0x1006, 0, &240_u32.to_le_bytes());
            bench.write(1, 0x1005, 0, &0x4000_0080_u32.to_le_bytes());
        }
        "sync-counter-producer" => {
            bench.write(1, 0x1019, 0, &[3]);
            // The manual prints 240 us as the longest period.
            bench.write(1, 0x1006, 0, &240_u32.to_le_bytes());
            bench.sent.clear();
            bench.write(1, 0x1005, 0, &0x4000_0080_u32.to_le_bytes());
        }
        "emcy-stopped" => {
            watch(&mut bench);
            nmt(&mut bench, 2, 1);
        }
        "emcy-life" => {
            bench.write(1, 0x1019, 0, &[240]);
            watch(&mut bench);
        }
        "map-missing-object" | "map-dummy" => {
            destroy(&mut bench);
            bench.write(1, 0x1600, 0, &[0]);
        }
        "map-invalid-enable" => {
            destroy(&mut bench);
            bench.write(1, 0x1600, 0, &[0]);
            for sub in 1..=4 {
                bench.write(1, 0x1600, sub, &0x607A_0020_u32.to_le_bytes());
            }
        }
        "tpdo-inhibit" => bench.write(1, 0x1800, 1, &0xC000_0181_u32.to_le_bytes()),
        _ => {}
    }
    bench
}

/// The drive watches the heartbeat of node 5, which has come once.
fn watch(bench: &mut Bench) {
    bench.write(1, 0x1016, 1, &0x0005_00C8_u32.to_le_bytes());
    bench.send(&Frame::data_frame(0x705, &[5]));
}

/// RPDO 1 is not in use.
fn destroy(bench: &mut Bench) {
    bench.write(1, 0x1400, 1, &0x8000_0201_u32.to_le_bytes());
}

fn nmt(bench: &mut Bench, command: u8, node: u8) {
    bench.send(&Frame::data_frame(0, &[command, node]));
    bench.run(20);
    bench.sent.clear();
}

/// What happens in a line without a frame.
pub fn happen(product: &str, sequence: &str, _: u64, bench: &mut Bench) -> Result<(), String> {
    match (product, sequence) {
        ("tc1", "encode-unsigned16") => shown(276_u16.to_le_bytes(), [0x14, 0x01]),
        ("tc1", "encode-integer16") => shown((-276_i16).to_le_bytes(), [0xEC, 0xFE]),
        ("tc1", "emcy-stopped") => {
            bench.run(300);
            let sent: Vec<_> = bench
                .sent
                .drain(..)
                .map(|frame| frame.standard_id())
                .collect();
            shown(sent, vec![])
        }
        _ => Err("nothing is known to happen here".to_owned()),
    }
}

fn shown<T: PartialEq + std::fmt::Debug>(came: T, told: T) -> Result<(), String> {
    (came == told)
        .then_some(())
        .ok_or_else(|| format!("{came:?}, and not {told:?}"))
}

/// What happens before the drive sends something of its own.
pub fn before(product: &str, sequence: &str, step: u64, bench: &mut Bench) {
    match (product, sequence, step) {
        ("tc1", "heartbeat", 3) => bench.send(&Frame::data_frame(0, &[1, 1])),
        ("tc1", "heartbeat", 4) => bench.send(&Frame::data_frame(0, &[2, 1])),
        ("tc1", "tpdo-sync" | "rpdo-sync", 3) => nmt(bench, 1, 1),
        ("s200", "S14-emcy", 1) => {
            bench.drive.plant_mut().fault = Some(0x4310);
            bench.run(5);
        }
        // Nothing is heard of node 5; then a SYNC has no counter. Node 5 is back; a SYNC is as it should be.
        ("tc1", "emcy-life", 1) => bench.run(300),
        ("tc1", "emcy-life", 2) => bench.send(&Frame::data_frame(0x080, &[])),
        ("tc1", "emcy-life", 3) => bench.send(&Frame::data_frame(0x705, &[5])),
        ("tc1", "emcy-life", 4) => bench.send(&Frame::data_frame(0x080, &[1])),
        _ => {}
    }
}

/// What is to be seen when all frames are played.
pub fn after(product: &str, sequence: &str, bench: &mut Bench) -> Result<(), String> {
    match (product, sequence) {
        ("lmd", "lss-global") => {
            bench.run(100);
            let statusword = bench.read(0x42, 0x6041, 0) & 0x6F;
            shown(statusword, 0x40)
        }
        ("lmd", "profile-position") => {
            bench.run(20_000);
            // 30000 is replaced by 3000; 100000 further, replaced by 3000 further than what was commanded.
            let position = bench.read(0x41, 0x6064, 0) as i32;
            shown(position % 1_000, 0)
        }
        ("s200", "S08-stored-task-sdo" | "S10-stored-task-repeat") => {
            bench.run(2_000);
            let times = if sequence.starts_with("S08") { 1 } else { 2 };
            // The repeat begins in the midst of the first, and counts from its target.
            shown(bench.read(3, 0x6064, 0), 5_000 * times)
        }
        ("nanotec", "start-travel-node34") => shown(bench.read(34, 0x6064, 0), 0),
        ("tc1", "rpdo-too-long" | "pdo-default") => shown(bench.read(1, 0x6040, 0), 6),
        ("tc1", "preop-no-pdo" | "rpdo-disabled-default") => shown(bench.read(1, 0x6040, 0), 0),
        ("tc1", "rtr-ignored") => {
            bench.sent.clear();
            bench.send(&Frame::remote_frame(0x181, 0));
            shown(bench.sent.len(), 0)
        }
        _ => Ok(()),
    }
}
