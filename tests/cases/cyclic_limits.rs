//! The cyclic modes 7, 8 and 9 at software limits and limit switches, in virtual time.

use canopen::Frame;
use tests::drive::INTERNAL_LIMIT;

use crate::cyclic_position::Master;

#[test]
fn m44_a_stop_out_of_cyclic_position_ends_before_the_software_limit() {
    type Stops = fn(&mut Master);
    let ways: [(&str, Stops); 4] = [
        ("halt", |master| master.controlword = 0x010F),
        ("disable operation", |master| master.controlword = 0x0007),
        ("605Ah = 1", |master| master.controlword = 0x0002),
        ("another mode", |master| {
            let mode = [0x2F, 0x60, 0x60, 0, 1, 0, 0, 0];
            master.drive.send_frame(Frame::data_frame(0x604, &mode));
        }),
    ];
    for (what, stops) in ways {
        let mut master = Master::new(8, 1_000);
        master.drive.write_i32(0x607D, 1, -10_000);
        master.drive.write_i32(0x607D, 2, 10_000);
        master.drive.write_i16(0x605A, 0, 1);
        master.steps([0; 100]);
        // 20,000 increments/s: 2,000 to rest on 6084h, 200 on 6085h.
        master.steps((1..=480).map(|k| k * 20));
        assert!(!master.has(INTERNAL_LIMIT));
        stops(&mut master);
        master.steps((481..=490).map(|k| k * 20));
        assert!(master.has(INTERNAL_LIMIT), "{what}: another ramp");
        master.steps([9_800; 300]);
        let rest = master.drive.position();
        assert!((9_500..=10_000).contains(&rest), "{what}: {rest}");
        assert!(!master.has(INTERNAL_LIMIT), "{what}: it stands");
    }
}
