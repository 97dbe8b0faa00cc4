//! SYNC at 1 kHz with four receive and four transmit PDOs: every counter that goes in comes out, once, together with its sisters, and always
//! equally late.
//!
//! The ordinary run has 3,000 SYNCs; `cargo xtask soak` sets the variable below to as many as are wanted.

use std::env;

use canopen::{BitRate, Duration, Frame, Instant};
use master::bus::simulated::Bus;
use master::{MappedObject, Master, NmtCommand, PdoSetup};
use sim::Axis402;
use sim::drive::Setup;

/// SYNCs on one bus, which keeps a record of its frames.
const STRETCH: u32 = 60_000;

/// Numbers of 32 bits that a PDO may carry in either direction: accelerations.
const OBJECTS: [u16; 4] = [0x6083, 0x6084, 0x6085, 0x609A];

const RECEIVE: [u16; 4] = [0x204, 0x304, 0x404, 0x504];
const TRANSMIT: [u16; 4] = [0x184, 0x284, 0x384, 0x484];

/// A drive of node-ID 4 that copies four numbers from receive PDOs to transmit PDOs.
fn master_of_four() -> Master {
    let mut master = Master::new(Bus::new(BitRate::Kbit1000));
    let drive = Axis402::new(Setup::with_node_id(1, 4));
    master.bus_mut().attach(drive);
    master.run_for(Duration::from_ticks(10_000));
    for ((number, object), cob_ids) in (1..).zip(OBJECTS).zip(RECEIVE.into_iter().zip(TRANSMIT)) {
        let setup = |cob_id| PdoSetup {
            cob_id,
            transmission_type: 1,
            inhibit_time: None,
            event_timer: None,
            objects: vec![MappedObject::new(object, 32)],
        };
        master.set_up_rpdo(4, number, &setup(cob_ids.0)).unwrap();
        master.set_up_tpdo(4, number, &setup(cob_ids.1)).unwrap();
    }
    master.nmt(NmtCommand::Start, 4);
    master.run_for(Duration::from_ticks(10_000));
    master.take_received();
    master
}

/// Plays so many SYNCs; returns by how many of them the counters come later.
fn play(syncs: u32) -> u32 {
    let mut master = master_of_four();
    let start = master.now();
    let mut lag = None;
    for count in 1..=syncs {
        for cob_id in RECEIVE {
            master.send_data(cob_id, &count.to_le_bytes());
        }
        // Behind what is sent before it, and in its own time whatever the bus has to do.
        master.sync();
        let end = start + Duration::millis(u64::from(count));
        master.run_for(end - master.now());
        let received = master.take_received();
        let counters: Vec<u32> = TRANSMIT
            .iter()
            .map(|cob_id| counter(&received, *cob_id))
            .collect();
        assert_eq!(received.len(), TRANSMIT.len(), "{count}: {received:?}");
        // The first SYNCs show what was there before.
        if count > 2 {
            let together = counters.iter().all(|other| *other == counters[0]);
            assert!(together, "{count}: {counters:?}");
            let late = count - counters[0];
            assert_eq!(*lag.get_or_insert(late), late, "{count}");
        }
    }
    lag.unwrap()
}

/// The number in the one frame with this identifier.
fn counter(received: &[(Instant, Frame)], cob_id: u16) -> u32 {
    let frames = received.iter().map(|(_, frame)| frame);
    let mut frames = frames.filter(|frame| frame.standard_id() == Some(cob_id));
    let frame = frames.next().unwrap();
    assert_eq!(frames.next(), None);
    u32::from_le_bytes(frame.payload().try_into().unwrap())
}

#[test]
fn every_counter_comes_back_with_its_sisters() {
    let wanted = env::var("AXIS402_SOAK_SYNCS").map_or(3_000, |text| {
        text.parse()
            .unwrap_or_else(|_| panic!("AXIS402_SOAK_SYNCS is no number: {text}"))
    });
    let mut left: u32 = wanted;
    while left > 2 {
        let lag = play(left.min(STRETCH));
        assert!(lag <= 1, "{lag} SYNCs late");
        left = left.saturating_sub(STRETCH);
    }
    println!("{wanted} SYNCs");
}
