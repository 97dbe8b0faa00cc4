//! Automatic bit rate detection: a drive that listens until it knows the bit rate, and never disturbs.

use canopen::cia305::DETECTABLE;
use canopen::{BitRate, BitTiming, Configuration, Duration, Frame, Instant, NodeId};
use master::bus::Station;
use master::bus::simulated::{Bus, Handle};
use sim::Axis402;
use sim::drive::Setup;

/// A node that sends a heartbeat now and then at its bit rate.
#[derive(Debug)]
struct Node {
    cob_id: u16,
    bit_rate: BitRate,
    period: Duration,
    next: Instant,
    waiting: bool,
}

impl Node {
    fn new(cob_id: u16, bit_rate: BitRate, milliseconds: u64) -> Self {
        Self {
            cob_id,
            bit_rate,
            period: Duration::from_ticks(milliseconds * 1_000),
            next: Instant::from_ticks(3_000),
            waiting: false,
        }
    }
}

impl Station for Node {
    fn receive(&mut self, _: &Frame, _: Instant) {}

    fn poll(&mut self, now: Instant) -> Instant {
        if now >= self.next {
            self.next = now + self.period;
            self.waiting = true;
        }
        self.next
    }

    fn transmit(&mut self) -> Option<Frame> {
        let cob_id = self.cob_id;
        std::mem::take(&mut self.waiting).then(|| Frame::data_frame(cob_id, &[0x05]))
    }

    fn bit_rate(&self) -> Option<BitRate> {
        Some(self.bit_rate)
    }
}

const NODE_ID: NodeId = NodeId::new(4).unwrap();

/// A drive that has to find the bit rate.
fn searching() -> Axis402 {
    Axis402::new(Setup {
        settings: Some(Configuration {
            node_id: NODE_ID,
            bit_timing: BitTiming::Automatic,
        }),
        ..Setup::unconfigured(1)
    })
}

/// Two nodes with a heartbeat, so that frames are acknowledged, and a drive.
fn network(bit_rate: BitRate, milliseconds: u64) -> (Bus, Handle<Axis402>) {
    let mut bus = Bus::new(bit_rate);
    bus.attach(Node::new(0x711, bit_rate, milliseconds));
    bus.attach(Node::new(0x712, bit_rate, milliseconds));
    let drive = bus.attach(searching());
    (bus, drive)
}

/// Whether the boot-up message of the drive was on the bus.
fn has_booted(bus: &Bus) -> bool {
    let boot_up = Frame::data_frame(0x704, &[0x00]);
    bus.trace().iter().any(|logged| logged.frame == boot_up)
}

#[test]
fn every_bit_rate_is_found_and_nothing_is_disturbed() {
    for bit_rate in DETECTABLE {
        for milliseconds in [20, 1_000] {
            let (mut bus, drive) = network(bit_rate, milliseconds);
            let start = bus.now();
            while !has_booted(&bus) {
                assert_eq!(bus.destroyed(), 0, "the drive must not disturb");
                bus.run_for(Duration::from_ticks(10_000));
                let passed = (bus.now() - start).to_millis();
                assert!(passed < 12_000, "{bit_rate:?} is not found");
            }
            assert_eq!(bus.station(drive).bit_rate(), Some(bit_rate));
            let settings = bus.station(drive).device().node().settings();
            assert_eq!(settings.bit_rate, bit_rate);
            let first = bus.trace().iter().find(|logged| logged.sender == 2);
            assert_eq!(
                first.map(|logged| logged.frame.payload()),
                Some(&[0x00][..])
            );
        }
    }
}

#[test]
fn on_a_silent_network_the_drive_is_silent_too() {
    let (mut bus, drive) = network(BitRate::Kbit250, 100_000_000);
    // The first heartbeats are over before the drive has come to this bit rate.
    bus.run_for(Duration::from_ticks(60_000_000));
    assert!(bus.station(drive).is_silent());
    assert!(bus.trace().iter().all(|logged| logged.sender != 2));
}

#[test]
fn a_master_alone_on_the_bus_is_found_when_it_is_error_passive() {
    let mut bus = Bus::new(BitRate::Kbit125);
    bus.attach(Node::new(0x711, BitRate::Kbit125, 100));
    let drive = bus.attach(searching());
    bus.run_for(Duration::from_ticks(12_000_000));
    assert_eq!(bus.station(drive).bit_rate(), Some(BitRate::Kbit125));
    assert!(has_booted(&bus));
}

#[test]
fn lss_can_have_the_bit_rate_found_while_the_drive_runs() {
    let mut bus = Bus::new(BitRate::Kbit1000);
    let drive = bus.attach(Axis402::new(Setup::with_node_id(1, 4)));
    bus.attach(Node::new(0x711, BitRate::Kbit20, 200));
    bus.attach(Node::new(0x712, BitRate::Kbit20, 200));
    let mut master = master::Master::new(bus);
    master
        .expect_boot_up(4, Duration::from_ticks(5_000_000))
        .unwrap();
    master.lss_switch_to_configuration();
    // Index 9 of table 0, then activate with a delay of 100 ms.
    let configure = [0x13, 0, 9, 0, 0, 0, 0, 0];
    let activate = [0x15, 100, 0, 0, 0, 0, 0, 0];
    for request in [configure, activate] {
        master.send(Frame::data_frame(0x7E5, &request));
        master.run_for(Duration::from_ticks(20_000));
    }
    master.run_for(Duration::from_ticks(15_000_000));
    let drive = master.station(drive);
    assert_eq!(drive.bit_rate(), Some(BitRate::Kbit20));
    assert!(!drive.is_silent());
    assert_eq!(drive.device().node().settings().bit_rate, BitRate::Kbit20);
}
