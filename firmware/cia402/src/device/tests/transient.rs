//! Quick stop active and fault reaction active reach the bus, however short they are.

use super::rig::Station;
use crate::state_machine::State;

const QUICK_STOP: &str = "184 17 02 01";
const DISABLED: &str = "184 50 02 01";

/// Runs without anything leaving: others have the bus.
fn blocked(station: &mut Station, count: usize) {
    for _ in 0..count {
        station.control_tick();
        station.device.poll(station.now, &mut station.exchange);
    }
}

/// A drive in operation enabled, with these parameters of TPDO 1: transmission type, inhibit time in multiples of 100 µs.
fn enabled(transmission_type: u32, inhibit_time: u32) -> Station {
    let mut station = Station::enabled();
    station.download(0x1800, 1, 4, 0x8000_0184).unwrap();
    station.download(0x1800, 2, 1, transmission_type).unwrap();
    station.download(0x1800, 3, 2, inhibit_time).unwrap();
    // The other one would tell as well.
    station.download(0x1801, 1, 4, 0x8000_0284).unwrap();
    // An event that answers at once.
    station.send(0x604, &[0x23, 0x00, 0x18, 0x01, 0x84, 0x01, 0x00, 0x00]);
    station
}

/// Quick stop, with 605Ah = 1.
fn stop(station: &mut Station) {
    station.send(0x204, &[0x02, 0x00, 0x01]);
}

/// Frames of TPDO 1 since the last call.
fn shown(station: &mut Station) -> std::vec::Vec<std::string::String> {
    let frames = station.take().into_iter();
    frames.filter(|frame| frame.starts_with("184")).collect()
}

#[test]
fn m08_a_quick_stop_is_seen_whatever_the_bus_does() {
    // The inhibit time runs, as a statusword has just left.
    let mut station = enabled(255, 100);
    station.milliseconds(30);
    station.take();
    station.send(0x204, &[0x0F, 0x01, 0x01]);
    station.milliseconds(2);
    stop(&mut station);
    station.milliseconds(40);
    let frames = shown(&mut station);
    assert!(frames.contains(&QUICK_STOP.into()), "{frames:?}");
    assert_eq!(frames.last().unwrap(), DISABLED);
    // It waits for SYNC.
    for transmission_type in [0, 1] {
        let mut station = enabled(transmission_type, 0);
        for cycle in 0..6 {
            station.send(0x080, &[]);
            station.milliseconds(1);
            if cycle == 2 {
                station.take();
                stop(&mut station);
            }
            station.milliseconds(9);
        }
        let frames = shown(&mut station);
        assert_eq!(frames[..2], [QUICK_STOP, DISABLED], "{transmission_type}");
    }
    // The bus is busy.
    let mut station = enabled(255, 0);
    station.milliseconds(5);
    station.take();
    stop(&mut station);
    blocked(&mut station, 20);
    assert_eq!(station.state(), State::QuickStopActive);
    station.milliseconds(5);
    assert_eq!(shown(&mut station), [QUICK_STOP, DISABLED]);
}

#[test]
fn m10_a_fault_reaction_is_seen_and_puts_no_power_off() {
    let mut station = enabled(255, 0);
    station.download(0x605E, 0, 2, 0).unwrap();
    station.milliseconds(5);
    station.take();
    station.fault = Some(0x4210);
    blocked(&mut station, 1);
    assert!(!station.power, "605Eh = 0: at once");
    blocked(&mut station, 19);
    assert_eq!(station.state(), State::FaultReactionActive);
    station.milliseconds(5);
    assert_eq!(shown(&mut station), ["184 1F 02 01", "184 18 02 01"]);
}

#[test]
fn a_state_waits_50_ms_for_a_bus_that_stays_blocked() {
    let mut station = enabled(255, 0);
    station.milliseconds(5);
    stop(&mut station);
    blocked(&mut station, 50);
    assert_eq!(station.state(), State::QuickStopActive);
    blocked(&mut station, 2);
    assert_eq!(station.state(), State::SwitchOnDisabled);
}

#[test]
fn disable_voltage_waits_for_nobody() {
    let mut station = enabled(255, 0);
    station.milliseconds(5);
    stop(&mut station);
    blocked(&mut station, 2);
    station.send(0x204, &[0x00, 0x00, 0x01]);
    blocked(&mut station, 1);
    assert_eq!(station.state(), State::SwitchOnDisabled);
    assert!(!station.power);
}

#[test]
fn nobody_waits_where_no_pdo_tells() {
    // TPDO 1 is asked for only, or not there.
    for transmission_type in [253, 255] {
        let mut station = enabled(transmission_type, 0);
        if transmission_type == 255 {
            station.download(0x1800, 1, 4, 0x8000_0184).unwrap();
        }
        station.milliseconds(5);
        stop(&mut station);
        blocked(&mut station, 2);
        assert_eq!(station.state(), State::SwitchOnDisabled);
    }
    // The node is stopped: 6007h makes a quick stop of it.
    let mut station = enabled(255, 0);
    station.milliseconds(5);
    station.send(0x000, &[0x02, 0x04]);
    blocked(&mut station, 1);
    assert_eq!(station.state(), State::QuickStopActive);
    blocked(&mut station, 2);
    assert_eq!(station.state(), State::SwitchOnDisabled);
}

#[test]
fn m08_a_pdo_that_a_sync_sends_before_the_device_is_polled_shows_the_state() {
    let mut station = enabled(1, 0);
    station.milliseconds(5);
    stop(&mut station);
    station.control_tick();
    station.take();
    station.send(0x080, &[]);
    assert_eq!(shown(&mut station), [QUICK_STOP]);
    station.milliseconds(3);
    assert_eq!(station.state(), State::SwitchOnDisabled);
}

#[test]
fn a_state_that_comes_again_before_the_device_looks_is_shown_already() {
    let mut station = enabled(255, 0);
    // It stays, and the next one does not.
    station.download(0x605A, 0, 2, 6).unwrap();
    stop(&mut station);
    station.milliseconds(10);
    station.download(0x605A, 0, 2, 2).unwrap();
    // With bit 10: it stands.
    assert_eq!(shown(&mut station).last().unwrap(), "184 17 06 01");
    station.send(0x204, &[0x0F, 0x00, 0x01]);
    let sent = station.now;
    station.control_tick();
    assert_eq!(
        State::from_statusword(station.exchange.actuals_at(station.now).statusword),
        Some(State::OperationEnabled)
    );
    // These frames were sent without a pause, but the second is handed over late.
    station.deliver(0x204, &[0x02, 0x00, 0x01], sent);
    station.control_tick();
    station.milliseconds(4);
    assert_eq!(station.state(), State::SwitchOnDisabled);
}
