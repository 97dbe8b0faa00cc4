//! Layer setting services while the node is Pre-operational, Operational or Stopped: they are answered alike in each, change
//! nothing of it, and hold nothing up.

use tests::drive::OPERATION_ENABLED;
use tests::{Bench, DriveBench};

/// The NMT states with the command that leads there from Pre-operational, and what error control says of them.
const STATES: [(Option<&str>, &str); 3] = [
    (None, "7F"),
    (Some("000 [2] 01 04"), "05"),
    (Some("000 [2] 02 04"), "04"),
];

/// Node 4 in each of these states, with what error control says of it.
fn in_each_state() -> impl Iterator<Item = (Bench, &'static str)> {
    STATES.into_iter().map(|(command, state)| {
        let mut bench = Bench::node(4);
        if let Some(command) = command {
            bench.send(command);
            bench.drain(5);
        }
        (bench, state)
    })
}

/// A request and what answers it.
fn ask(bench: &mut Bench, request: &str, answer: &str) {
    bench.send(&format!("7E5: {request}"));
    bench.expect(&format!("7E4: {answer}"));
}

#[test]
fn l18_every_service_is_answered_in_each_nmt_state_and_leaves_it() {
    for (mut bench, state) in in_each_state() {
        // Identify remote slave, in the waiting state.
        for request in [
            "46 44 33 22 11",
            "47 88 77 66 55",
            "48",
            "49 FF FF FF FF",
            "4A",
        ] {
            bench.send(&format!("7E5: {request}"));
        }
        ask(&mut bench, "4B FF FF FF FF", "4F");
        // Switch state selective.
        for request in ["40 44 33 22 11", "41 88 77 66 55", "42 CC BB AA 99"] {
            bench.send(&format!("7E5: {request}"));
        }
        ask(&mut bench, "43 01 FF EE DD", "44");
        ask(&mut bench, "5A", "5A 44 33 22 11");
        ask(&mut bench, "5E", "5E 04");
        ask(&mut bench, "11 0B", "11 00");
        ask(&mut bench, "13 00 02", "13 00");
        ask(&mut bench, "17", "17 00");
        // A configured node is silent for these.
        bench.send("7E5: 4C");
        bench.send("7E5: 51 00 00 00 00 80 00 00");
        bench.send("7E5: 04 00");
        bench.silence(20);
        bench.send("704 [1] rtr");
        bench.expect(&format!("704 [1] {state}"));
    }
}

#[test]
fn l18_a_new_node_id_waits_for_reset_communication_in_each_nmt_state() {
    for (mut bench, state) in in_each_state() {
        bench.send("7E5: 04 01");
        ask(&mut bench, "11 0B", "11 00");
        ask(&mut bench, "5E", "5E 04");
        bench.send("7E5: 04 00");
        bench.silence(20);
        bench.send("704 [1] rtr");
        bench.expect(&format!("704 [1] {state}"));
        bench.send("000 [2] 82 04");
        bench.expect("70B [1] 00");
        bench.send("70B [1] rtr");
        bench.expect("70B [1] 7F");
    }
}

#[test]
fn l06_the_bit_rate_is_switched_in_each_nmt_state() {
    for (mut bench, state) in in_each_state() {
        bench.send("7E5: 04 01");
        ask(&mut bench, "13 00 02", "13 00");
        bench.send("7E5: 15 14 00");
        bench.drain(41);
        assert_eq!(bench.device().bit_rates.len(), 1);
        bench.send("704 [1] rtr");
        bench.expect(&format!("704 [1] {state}"));
    }
}

#[test]
fn l06_a_switch_of_the_bit_rate_does_not_hold_up_the_motor() {
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
