//! The runtime on a host of its own: virtual time, a controller with one mailbox, flash that may fail.

mod rig;

use canopen::settings::{PowerOn, Source};
use canopen::{BitRate, BitTiming, Configuration, Frame, Instant, NodeId};
use runtime::inbox::DEPTH;
use runtime::{Controller, PowerUp};

use rig::*;

#[test]
fn one_run_takes_no_more_frames_than_can_wait() {
    let mut rig = Rig::at(BitTiming::Fixed(BitRate::Kbit500));
    for _ in 0..DEPTH + 3 {
        rig.receive(0x123, &[]);
    }
    rig.run();
    assert_eq!(rig.bus.received.len(), 3);
}

#[test]
fn frames_wait_for_room_and_the_first_is_the_boot_up_message() {
    let mut rig = Rig::at(BitTiming::Fixed(BitRate::Kbit500));
    assert_eq!(rig.bus.started, [BitRate::Kbit500]);
    rig.run();
    assert_eq!(rig.bus.mailbox, Some(Frame::data_frame(0x704, &[0])));
    rig.receive(0x604, &[0x40, 0, 0x10, 0, 0, 0, 0, 0]);
    rig.run();
    assert_eq!(rig.bus.mailbox.take(), Some(Frame::data_frame(0x704, &[0])));
    rig.run();
    let answer = rig.bus.mailbox.and_then(|frame| frame.standard_id());
    assert_eq!(answer, Some(0x584));
}

#[test]
fn the_bit_rate_changes_at_its_moment_and_behind_the_frame_on_the_bus() {
    let mut rig = Rig::stored(Flash::default());
    rig.ticks(2);
    rig.lss(&[0x04, 1]);
    rig.lss(&[0x13, 0, 2]);
    rig.lss(&[0x15, 10]);
    rig.drain();
    let switch = rig.around.now + 10_000;
    assert!(rig.run() <= Instant::from_ticks(switch));
    rig.ticks(9);
    assert_eq!(rig.bus.started, [BitRate::Kbit1000]);
    rig.bus.leaves = false;
    rig.ticks(3);
    assert_eq!(rig.bus.started, [BitRate::Kbit1000]);
    rig.bus.leaves = true;
    rig.ticks(1);
    assert_eq!(rig.bus.started, [BitRate::Kbit1000, BitRate::Kbit500]);
}

#[test]
fn what_comes_before_the_controller_has_left_counts_for_the_bit_rate_it_had() {
    let mut rig = Rig::at(BitTiming::Automatic);
    assert_eq!(rig.bus.listens, [BitRate::Kbit1000]);
    rig.ticks(1_199);
    rig.bus.leaves = false;
    rig.ticks(5);
    assert_eq!(rig.bus.listens, [BitRate::Kbit1000]);
    assert!(rig.drain().is_empty(), "it listens in silence");
    rig.receive(0x123, &[]);
    rig.bus.leaves = true;
    let sent = rig.ticks(1);
    assert_eq!(rig.bus.started, [BitRate::Kbit1000]);
    assert_eq!(sent, [Frame::data_frame(0x704, &[0])]);
}

#[test]
fn a_silent_network_has_one_bit_rate_tried_after_the_other() {
    let mut rig = Rig::at(BitTiming::Automatic);
    rig.ticks(2_401);
    let tried = [BitRate::Kbit1000, BitRate::Kbit500, BitRate::Kbit20];
    assert_eq!(rig.bus.listens, tried);
}

#[test]
fn settings_are_stored_when_the_drive_is_safe_and_not_before() {
    let mut rig = Rig::stored(Flash::default());
    rig.lss(&[0x04, 1]);
    rig.lss(&[0x11, 11]);
    rig.drain();
    rig.lss(&[0x17]);
    // No control tick has told that the motor has no power.
    assert_eq!(answer(&rig.drain()), None);
    let sent = rig.ticks(2);
    assert_eq!(answer(&sent).map(|data| data[1]), Some(0));
    assert_eq!(rig.flash().settings.unwrap().node_id.get(), 11);
}

#[test]
fn who_orders_to_store_while_the_drive_is_not_safe_is_refused_in_time() {
    let mut rig = Rig::stored(Flash::default());
    rig.lss(&[0x04, 1]);
    rig.lss(&[0x11, 11]);
    rig.lss(&[0x17]);
    rig.drain();
    assert_eq!(rig.run(), Instant::from_ticks(50_000));
    rig.around.now = 50_000;
    let sent = rig.drain();
    assert_eq!(answer(&sent).map(|data| data[1]), Some(2));
    assert_eq!(rig.flash().settings.unwrap().node_id.get(), 4);
}

#[test]
fn flash_that_fails_is_told() {
    let mut rig = Rig::stored(Flash {
        is_broken: true,
        ..Flash::default()
    });
    rig.lss(&[0x04, 1]);
    rig.lss(&[0x17]);
    let sent = rig.ticks(2);
    let mut results = sent.iter().filter(|frame| frame.payload()[0] == 0x17);
    let last = results.next_back().map(|frame| frame.payload()[1]);
    assert_eq!(last, Some(2));
}

#[test]
fn a_factory_reset_forgets_and_counts_even_where_flash_does_not() {
    let settings = Configuration {
        node_id: NodeId::new(9).unwrap(),
        bit_timing: BitTiming::Fixed(BitRate::Kbit20),
    };
    for is_broken in [false, true] {
        let mut store = Some(Flash {
            settings: Some(settings),
            is_broken,
        });
        let choose = |factory_reset, store: &mut Option<Flash>| -> PowerOn {
            let power_up = PowerUp {
                factory_reset,
                ..PowerUp::default()
            };
            power_up.choose(store, Bus::BIT_RATES)
        };
        let kept = choose(false, &mut store).node_id;
        assert_eq!((kept.value.get(), kept.source), (9, Source::Store));
        let power_on = choose(true, &mut store);
        assert_eq!(power_on.node_id.source, Source::Factory);
        assert_eq!(power_on.bit_timing.source, Source::Factory);
        assert_eq!(store.unwrap().settings.is_some(), is_broken);
    }
}

#[test]
fn the_watchdog_is_fed_while_the_node_lives() {
    let mut rig = Rig::at(BitTiming::Fixed(BitRate::Kbit500));
    let exchange = &mut rig.around.exchange;
    for (alive, fed) in [(true, 1), (false, 1), (true, 2)] {
        (rig.control).tick(0, alive, &mut rig.stage, exchange);
        assert_eq!(rig.stage.fed, fed);
    }
}

/// Control ticks in which the node does not run; then the error code.
fn hang(rig: &mut Rig, ticks: u64) -> u16 {
    for _ in 0..ticks {
        rig.around.now += TICK.ticks();
        rig.stage.now = rig.around.now;
        let exchange = &mut rig.around.exchange;
        (rig.control).tick(0, false, &mut rig.stage, exchange);
    }
    let actuals = rig.around.exchange.actuals_at(canopen::time::NEVER);
    actuals.error_code
}

#[test]
fn a_node_that_hangs_is_a_fault_while_the_motor_has_current() {
    let mut rig = Rig::at(BitTiming::Fixed(BitRate::Kbit500));
    rig.ticks(3);
    assert_eq!(hang(&mut rig, 100), 0);
    rig.enable();
    let fed = rig.stage.fed;
    assert_eq!(hang(&mut rig, 19), 0);
    assert_eq!(rig.stage.fed, fed);
    assert_eq!(hang(&mut rig, 3), 0x6100);
    // The watchdog waits until the motor has no current, and no longer.
    while rig.stage.powered {
        let fed = rig.stage.fed;
        hang(&mut rig, 1);
        assert_eq!(rig.stage.fed, fed + u32::from(rig.stage.powered));
    }
    let fed = rig.stage.fed;
    hang(&mut rig, 100);
    assert_eq!(rig.stage.fed, fed);
}

#[test]
fn a_stage_that_fails_between_two_ticks_has_one_of_its_own() {
    for (code, fails) in [
        (
            0x3220,
            (|rig| rig.stage.has_no_supply = true) as fn(&mut Rig),
        ),
        (0x5400, |rig| rig.stage.fault = Some(0x5400)),
        (0x8110, |rig| rig.bus.lost += 1),
    ] {
        let mut rig = Rig::at(BitTiming::Fixed(BitRate::Kbit500));
        rig.ticks(3);
        // Nothing to save without current.
        fails(&mut rig);
        assert!(!rig.stop());
        (rig.stage.has_no_supply, rig.stage.fault) = (false, None);
        rig.ticks(3);
        rig.enable();
        assert!(!rig.stop());
        fails(&mut rig);
        assert!(rig.stop());
        // Frames that are lost are a fault with a ramp.
        assert!(!rig.stage.powered || code == 0x8110);
        assert!(!rig.stop());
        let actuals = rig.around.exchange.actuals_at(canopen::time::NEVER);
        assert_eq!(actuals.error_code, code);
    }
}

#[test]
fn frames_that_are_lost_without_power_are_a_message_and_no_fault() {
    let mut rig = Rig::at(BitTiming::Fixed(BitRate::Kbit500));
    rig.ticks(3);
    rig.bus.lost = 2;
    let sent = rig.ticks(2);
    let emergency = |frame: &&Frame| frame.standard_id() == Some(0x84);
    let codes: Vec<_> = sent.iter().filter(emergency).collect();
    assert_eq!(codes.len(), 1);
    assert_eq!(codes[0].payload()[..2], [0x10, 0x81]);
    let actuals = rig.around.exchange.actuals_at(canopen::time::NEVER);
    assert_eq!(actuals.error_code, 0);
}
