//! LSS on a drive whose motor has power: flash is written later, and a new bit rate holds nothing up.

use canopen::NodeId;
use tests::DriveBench;
use tests::drive::{OPERATION_ENABLED, SWITCH_ON_DISABLED};

/// A drive in operation enabled, in the configuration state, with a new node-ID.
fn configured() -> DriveBench {
    let mut bench = DriveBench::enabled(4);
    bench.drain(10);
    bench.send("7E5: 04 01");
    bench.send("7E5: 11 0B");
    bench.expect("7E4: 11 00");
    bench
}

/// The node-ID of the next power-on.
fn stored(bench: &mut DriveBench) -> NodeId {
    bench.axis().power_cycle();
    bench.axis().device().node().settings().node_id
}

#[test]
fn nothing_is_stored_while_the_motor_has_power() {
    let mut bench = configured();
    let began = bench.now();
    bench.send("7E5: 17");
    bench.drain_until("7E4: 17 02", 60);
    assert_eq!((bench.now() - began).to_millis(), 50);
    assert!(OPERATION_ENABLED.is_shown_by(bench.statusword()));
    // What could not be stored can be stored later.
    bench.command(0x00);
    bench.reaches(SWITCH_ON_DISABLED, 20);
    bench.send("7E5: 17");
    bench.drain_until("7E4: 17 00", 5);
    assert_eq!(stored(&mut bench).get(), 11);
}

#[test]
fn what_was_refused_is_not_stored() {
    let mut bench = configured();
    bench.send("7E5: 17");
    bench.drain_until("7E4: 17 02", 60);
    assert_eq!(stored(&mut bench).get(), 4);
}

#[test]
fn a_motor_that_is_switched_off_meanwhile_is_waited_for() {
    let mut bench = configured();
    bench.send("7E5: 17");
    bench.drain(30);
    bench.command(0x00);
    bench.drain_until("7E4: 17 00", 15);
    assert_eq!(stored(&mut bench).get(), 11);
}

#[test]
fn a_switch_of_the_bit_rate_does_not_hold_up_the_motor() {
    let moved = |requests: &[&str]| {
        let mut bench = DriveBench::enabled(4);
        bench.record_motion();
        bench.begin_move(5_000);
        for request in requests {
            bench.queue(request);
        }
        bench.drain(1_500);
        assert!(OPERATION_ENABLED.is_shown_by(bench.statusword()));
        assert_eq!(bench.position(), 5_000);
        bench.axis().motion_samples().to_vec()
    };
    let undisturbed = moved(&[]);
    // Silent for 200 ms, 500 kbit/s, silent for 200 ms again.
    let switched = moved(&["7E5: 04 01", "7E5: 13 00 02", "7E5: 15 C8 00"]);
    assert_eq!(switched, undisturbed);
}
