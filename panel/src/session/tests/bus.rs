//! What the page of the bus orders: numbers, bit rates, who is there.

use super::*;

#[test]
fn the_whole_bus_goes_to_another_bit_rate_and_all_are_there() {
    let (mut bench, _) = Bench::with(DriveSetup::with_node_id(1, NODE), false);
    bench.done(Order::Scan);
    let said = bench.done(Order::BitRate {
        kbit: 500,
        store: true,
    });
    assert_eq!(said, "at 500 kbit/s 1 of 1 nodes answer");
    bench.run_for(100);
    assert_eq!(bench.session.state().bus.kbit, Some(500));
    assert_eq!(bench.done(read("6041")), "0x0250 (switch on disabled)");
    let why = bench.refused(Order::BitRate {
        kbit: 300,
        store: false,
    });
    assert_eq!(why, "CiA 305 has no bit rate of 300 kbit/s");
}

#[test]
fn a_node_gets_another_number_and_keeps_it() {
    let (mut bench, _) = Bench::with(DriveSetup::with_node_id(1, NODE), false);
    bench
        .bus()
        .attach(Axis402::new(DriveSetup::with_node_id(2, 5)));
    bench.run_for(100);
    bench.done(Order::Scan);
    bench.done(Order::Choose { node: NODE });
    bench.done(Order::Enable);
    let order = |to| Order::Renumber {
        node: NODE,
        to,
        store: true,
    };
    assert_eq!(bench.refused(order(5)), "node-ID 5 is taken");
    assert_eq!(bench.refused(order(127)), "node-ID 127 is taken");
    for wrong in [0, 128, 255] {
        assert_eq!(bench.refused(order(wrong)), "a node-ID is 1 to 127");
    }
    assert_eq!(bench.done(order(9)), "node 4 is node 9 now");
    // It was not left with power, and the other one is as it was.
    assert!(bench.session.state().drive.is_none());
    bench.done(Order::Choose { node: 9 });
    assert_eq!(bench.drive_state(), Some(DriveState::SwitchOnDisabled));
    // Stored: it is so after a reset too.
    bench.done(Order::Nmt {
        command: crate::message::NmtOrder::Reset,
        node: 9,
    });
    bench.run_for(500);
    assert_eq!(bench.done(Order::Scan), "2 nodes");
    let nodes = &bench.session.state().nodes;
    let ids: Vec<_> = nodes.iter().map(|node| node.id).collect();
    assert_eq!(ids, [5, 9]);
}

#[test]
fn devices_without_a_node_id_are_found_and_left_as_they_are() {
    let (mut bench, _) = Bench::with(DriveSetup::unconfigured(0xC0FFEE), false);
    let said = bench.done(Order::Find);
    assert!(
        said.contains("product 00000402h, revision 00010000h, serial 00C0FFEEh"),
        "{said}"
    );
    assert!(said.ends_with("1 device without a node-ID"), "{said}");
    bench.done(Order::Scan);
    assert_eq!(bench.session.state().bus.unnumbered, Some(true));
}

#[test]
fn a_device_that_comes_later_is_asked_who_it_is() {
    let (mut bench, _) = Bench::with(DriveSetup::with_node_id(1, NODE), false);
    bench.done(Order::Scan);
    let late = DriveSetup::with_node_id(2, 9);
    bench.bus().attach(Axis402::new(late));
    bench.run_for(2_000);
    let nodes = &bench.session.state().nodes;
    let known: Vec<_> = nodes.iter().map(|node| (node.id, node.is_drive)).collect();
    assert_eq!(known, [(NODE, true), (9, true)]);
    // Who is silent is not asked for ever.
    let heartbeat = Frame::data_frame(0x705, &[0x05]);
    bench.session.traffic.follow(
        &crate::line::Passed {
            at: Instant::from_ticks(0),
            frame: heartbeat,
            own: false,
        },
        false,
    );
    bench.bus().take_trace();
    bench.run_for(5_000);
    let asked = bench.bus().take_trace();
    let asked = asked.iter().filter(|logged| {
        let is_read = logged.frame.payload().first() == Some(&0x40);
        is_read && logged.frame.standard_id() == Some(0x605)
    });
    assert_eq!(asked.count(), 3);
}
