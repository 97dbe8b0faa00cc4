//! `axis402 lss bitrate` and `lss store`.

use std::collections::VecDeque;

use canopen::time::NEVER;
use canopen::{BitRate, BitTiming, Duration, Frame, Instant};
use master::axis402::{BitRateSwitch, Console, find, store_settings, switch_bit_rate};
use master::bus::Station;
use master::bus::simulated::Handle;
use master::{Inbox, Line, LineDown, Master, Simulated};
use sim::Axis402;
use sim::drive::Setup;

use crate::bench::{Bench, refusal};

const SWITCH: BitRateSwitch = BitRateSwitch {
    to: BitRate::Kbit250,
    from: Some(BitRate::Kbit1000),
    store: true,
    delay: Duration::from_ticks(100_000),
};

fn listen_at(bench: &mut Bench, bit_rate: BitRate) {
    bench.master.line_mut().set_bit_rate(bit_rate).unwrap();
}

/// After power-on it boots at this bit rate.
fn boots_at(bench: &mut Bench, drive: Handle<Axis402>, node_id: u8, bit_rate: BitRate) {
    listen_at(bench, bit_rate);
    bench.master.station_mut(drive).power_cycle();
    bench
        .master
        .expect_boot_up(node_id, Duration::from_ticks(1_000_000))
        .unwrap();
}

fn switch(bench: &mut Bench, switch: BitRateSwitch) -> (String, u8) {
    refusal(bench.run(|master, console| switch_bit_rate(master, switch, console)))
}

/// Node 9 of another maker. It answers every SDO request, accepts every bit rate and may ignore it; 300 ms after it was told to store it refuses.
#[derive(Debug)]
struct Other {
    bit_rate: BitRate,
    /// Its bit rate once it was told to switch.
    switches_to: BitRate,
    refusal_at: Option<Instant>,
    answers: VecDeque<Frame>,
}

impl Other {
    fn switching_to(bit_rate: BitRate) -> Self {
        Self {
            bit_rate: BitRate::Kbit1000,
            switches_to: bit_rate,
            refusal_at: None,
            answers: VecDeque::new(),
        }
    }
}

impl Station for Other {
    fn receive(&mut self, frame: &Frame, now: Instant) {
        match (frame.standard_id(), frame.payload()) {
            (Some(0x609), _) => {
                let answer = [0x43, 0x00, 0x10, 0, 0, 0, 0, 0];
                self.answers.push_back(Frame::data_frame(0x589, &answer));
            }
            (Some(0x7E5), [0x13, ..]) => {
                let answer = [0x13, 0, 0, 0, 0, 0, 0, 0];
                self.answers.push_back(Frame::data_frame(0x7E4, &answer));
            }
            (Some(0x7E5), [0x15, ..]) => self.bit_rate = self.switches_to,
            (Some(0x7E5), [0x17, ..]) => {
                self.refusal_at = Some(now + Duration::from_ticks(300_000));
            }
            _ => {}
        }
    }

    fn poll(&mut self, now: Instant) -> Instant {
        if self.refusal_at.take_if(|at| *at <= now).is_some() {
            let answer = [0x17, 2, 0, 0, 0, 0, 0, 0];
            self.answers.push_back(Frame::data_frame(0x7E4, &answer));
        }
        self.refusal_at.unwrap_or(NEVER)
    }

    fn transmit(&mut self) -> Option<Frame> {
        self.answers.pop_front()
    }

    fn bit_rate(&self) -> Option<BitRate> {
        Some(self.bit_rate)
    }
}

/// A CAN interface whose bit rate is set outside.
struct Interface<'a>(&'a mut Simulated);

impl Line for Interface<'_> {
    fn now(&self) -> Instant {
        self.0.now()
    }

    fn send(&mut self, frame: Frame) {
        self.0.send(frame);
    }

    fn inbox(&mut self) -> &mut Inbox {
        self.0.inbox()
    }

    fn step(&mut self, end: Instant) -> Result<bool, LineDown> {
        self.0.step(end)
    }

    fn set_bit_rate(&mut self, _bit_rate: BitRate) -> Result<bool, LineDown> {
        Ok(false)
    }
}

#[test]
fn the_whole_bus_goes_to_another_bit_rate_and_stays_there() {
    let (mut bench, drives) = Bench::with_drives(&[4, 5]);
    let told = bench.told(|master, console| switch_bit_rate(master, SWITCH, console));
    assert_eq!(told, "at 250 kbit/s 2 of 2 nodes answer\n");
    for (drive, node_id) in [(0, 4), (1, 5)] {
        // LSS stored the rate; the node-ID is that of its set-up.
        boots_at(&mut bench, drives[drive], node_id, BitRate::Kbit250);
    }
}

#[test]
fn a_bus_without_devices_stays_at_its_bit_rate() {
    let refused = switch(&mut Bench::new(), SWITCH);
    assert_eq!(refused, ("no device answers".to_owned(), 1));
}

#[test]
fn where_one_device_refuses_the_bit_rate_the_others_store_the_old_one() {
    let (mut bench, drives) = Bench::with_drives(&[4]);
    let mut fixed = Setup::with_node_id(2, 5);
    fixed.build.bit_timing = Some(BitTiming::Fixed(BitRate::Kbit1000));
    bench.attach(Axis402::new(fixed));
    bench.master.run_for(Duration::from_ticks(10_000));
    let (line, code) = switch(&mut bench, SWITCH);
    assert!(line.ends_with("; all keep their bit rate"), "{line}");
    assert_eq!(code, 1);
    let told = bench.told(store_settings);
    assert_eq!(told, "stored, with 2 nodes on the bus\n");
    boots_at(&mut bench, drives[0], 4, BitRate::Kbit1000);
    // Where nobody knows the old bit rate, a person is told what would happen.
    let unknown = BitRateSwitch {
        from: None,
        ..SWITCH
    };
    let (line, _) = switch(&mut bench, unknown);
    assert!(
        line.ends_with("the others would store 250 kbit/s: power them off and on"),
        "{line}"
    );
}

#[test]
fn a_node_that_does_not_come_along_is_told_and_nobody_stores() {
    let (mut bench, drives) = Bench::with_drives(&[4]);
    bench.attach(Other::switching_to(BitRate::Kbit1000));
    assert_eq!(
        switch(&mut bench, SWITCH),
        (
            "at 250 kbit/s 1 of 2 nodes answer, lost: node 9; nothing is stored, power-on brings the old bit rate back"
                .to_owned(),
            1
        )
    );
    boots_at(&mut bench, drives[0], 4, BitRate::Kbit1000);
}

#[test]
fn a_refusal_to_store_is_heard_behind_the_consent_of_others() {
    let (mut bench, _) = Bench::with_drives(&[4]);
    bench.attach(Other::switching_to(BitRate::Kbit250));
    let (line, code) = switch(&mut bench, SWITCH);
    assert!(line.contains("cannot access its memory"), "{line}");
    assert!(line.ends_with("then `axis402 lss store`"), "{line}");
    assert_eq!(code, 1);
    // They part at power-on only: now all of them are at the new bit rate, and what has failed can be done again.
    let (line, _) = refusal(bench.run(store_settings));
    assert!(line.contains("cannot access its memory"), "{line}");
}

#[test]
fn an_interface_that_others_set_sends_nothing_at_the_old_bit_rate() {
    let (mut bench, drives) = Bench::with_drives(&[4, 255]);
    let (mut output, mut progress) = (Vec::new(), Vec::new());
    let mut console = Console::new(&mut output, &mut progress, false);
    let mut master = Master::on(Interface(bench.master.line_mut()));
    let from_outside = BitRateSwitch {
        from: None,
        ..SWITCH
    };
    switch_bit_rate(&mut master, from_outside, &mut console).unwrap();
    drop(console);
    let told = String::from_utf8(output).unwrap();
    assert!(told.contains("set the interface to 250 kbit/s"), "{told}");
    assert!(told.contains("`axis402 lss store`"), "{told}");
    let last = bench.master.bus().trace().last().unwrap().frame;
    assert_eq!(last.payload(), [0x15, 100, 0, 0, 0, 0, 0, 0]);

    // A person has set the interface.
    listen_at(&mut bench, BitRate::Kbit250);
    assert_eq!(
        bench.told(store_settings),
        "stored, with 1 node on the bus\n"
    );
    assert!(bench.told(find).ends_with("1 device without a node-ID\n"));
    boots_at(&mut bench, drives[0], 4, BitRate::Kbit250);
}
