//! A drive whose plug is pulled while it is put into service. Whatever the moment, it comes back with its old setting or its new
//! one, whole: node-ID and bit rate of one and the same store, and it can be put into service again.

use canopen::{BitRate, Duration, NodeId, Settings};
use master::bus::simulated::{Bus, Handle};
use master::{Failure, Master, NmtCommand};
use proptest::prelude::RngExt as _;
use proptest::test_runner::TestRng;
use tests::plugged::Plugged;

use crate::seeded::generator;

const SECOND: Duration = Duration::from_ticks(1_000_000);
const SWITCH_DELAY: Duration = Duration::from_ticks(20_000);

/// How long a fastscan takes: 133 steps of 10 ms.
const SCAN: u64 = 1_330_000;

/// How far the master came.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Progress {
    /// The drive has not been told to store.
    NotStored,
    /// It was told to, and has not answered.
    Storing,
    /// It has answered that it did.
    Stored,
    /// It uses the new setting, and stores parameters.
    InUse,
    /// Nothing was left to do.
    Done,
}

/// A drive with a plug and its master, life after life.
struct Service {
    master: Master,
    drive: Handle<Plugged>,
    /// What the drive has stored, as the master knows.
    settings: Settings,
    progress: Progress,
}

impl Service {
    /// A drive from the factory.
    fn new(serial_number: u32) -> Self {
        let mut master = Master::new(Bus::new(BitRate::Kbit1000));
        let drive = master.bus_mut().attach(Plugged::new(serial_number));
        let mut service = Self {
            master,
            drive,
            settings: Settings::default(),
            progress: Progress::Done,
        };
        service.follow(BitRate::Kbit1000);
        service
    }

    /// The master's own bit rate.
    fn follow(&mut self, bit_rate: BitRate) {
        self.master.port_mut().set_bit_rate(Some(bit_rate));
    }

    /// Gives the drive a new setting, lets it store and use it, and stores its parameters.
    fn put_into_service(&mut self, new: Settings) -> Result<(), Failure> {
        self.progress = Progress::NotStored;
        let master = &mut self.master;
        if self.settings.node_id.is_configured() {
            master.lss_switch_to_configuration();
        } else {
            let found = master.lss_fastscan()?;
            assert!(
                found.is_some() || master.station(self.drive).is_out(),
                "a drive without a node-ID is not found"
            );
        }
        master.lss_configure_node_id(new.node_id)?;
        master.lss_configure_bit_timing(new.bit_rate)?;
        self.progress = Progress::Storing;
        master.lss_store()?;
        self.progress = Progress::Stored;
        master.lss_activate_bit_timing(SWITCH_DELAY);
        master.run_for(SWITCH_DELAY);
        self.follow(new.bit_rate);
        let master = &mut self.master;
        master.run_for(SWITCH_DELAY * 2);
        master.lss_switch_to_waiting();
        let node = new.node_id.get();
        if self.settings.node_id.is_configured() {
            master.nmt(NmtCommand::ResetCommunication, 0);
        }
        master.expect_boot_up(node, SECOND)?;
        self.progress = Progress::InUse;
        master.write(node, 0x6081, 0, 4_321u32)?;
        master.write(node, 0x1010, 1, u32::from_le_bytes(*b"save"))?;
        self.progress = Progress::Done;
        Ok(())
    }

    /// The setting that the drive answers at, of those it may have.
    fn reach(&mut self, candidates: &[Settings]) -> Settings {
        let mut answers = Vec::new();
        for settings in candidates {
            self.follow(settings.bit_rate);
            let master = &mut self.master;
            master.take_received();
            master.lss_switch_to_configuration();
            if let Ok(node_id) = master.lss_inquire_node_id() {
                let node_id = node_id.expect("a node-ID is 1 to 127, or 255");
                answers.push(Settings {
                    node_id,
                    bit_rate: settings.bit_rate,
                });
            }
            master.lss_switch_to_waiting();
            master.run_for(SWITCH_DELAY);
        }
        answers.dedup();
        let [found] = answers[..] else {
            panic!("of {candidates:?} the drive answers at {answers:?}");
        };
        assert!(
            candidates.contains(&found),
            "{found:?} is neither of {candidates:?}"
        );
        found
    }

    /// Plugs the drive in and finds out which setting it has.
    fn plug_in(&mut self, new: Settings) {
        self.master.station_mut(self.drive).plug_in();
        self.master.run_for(SWITCH_DELAY);
        let old = self.settings;
        let found = self.reach(&[old, new]);
        match self.progress {
            Progress::NotStored => assert_eq!(found, old),
            Progress::Storing => {}
            Progress::Stored | Progress::InUse | Progress::Done => assert_eq!(found, new),
        }
        self.follow(found.bit_rate);
        self.settings = found;
        if found.node_id.is_configured() {
            let profile = self.master.read::<u32>(found.node_id.get(), 0x1000, 0);
            assert_eq!(profile, Ok(0x0004_0192));
        }
    }
}

/// Any setting at which a drive can be used. Rates are left out at which a frame takes longer than a step of the master's scan.
fn any_settings(random: &mut TestRng) -> Settings {
    let mut rates = BitRate::ALL.to_vec();
    rates.retain(|bit_rate| bit_rate.kbit_per_second() >= 125);
    Settings {
        node_id: NodeId::new(random.random_range(1..=127)).expect("1 to 127"),
        bit_rate: rates[random.random_range(0..rates.len())],
    }
}

/// Puts the drive into service with new settings while the plug is pulled at a random moment, or at a random byte of flash; then
/// plugs it in. Returns how far it came.
fn live(service: &mut Service, random: &mut TestRng) -> Progress {
    // Moments soon after a beginning are as likely as late ones: there one frame follows the other.
    let is_new = service.settings == Settings::default();
    let after = if is_new && random.random() { SCAN } else { 0 };
    let longest = 1 << random.random_range(8..=20);
    let life = Duration::from_ticks(after + random.random_range(0..longest));
    let end = service.master.now() + life;
    let drive = service.master.station_mut(service.drive);
    if random.random() {
        drive.pull_at(end);
    } else {
        // Up to a whole sector, so that cuts of an erase are as likely as those of a record.
        drive.pull_at_byte(1 << random.random_range(0..15));
    }
    let new = any_settings(random);
    let result = service.put_into_service(new);
    let is_out = service.master.station(service.drive).is_out();
    assert!(result.is_ok() || is_out, "without a reason: {result:?}");
    service.plug_in(new);
    service.progress
}

/// The lives must have ended in every part of putting into service.
fn all_kinds(ends: &[Progress]) {
    use Progress::{Done, InUse, NotStored, Stored, Storing};
    for progress in [NotStored, Storing, Stored, InUse, Done] {
        assert!(ends.contains(&progress), "no life ended as {progress:?}");
    }
}

#[test]
fn a_drive_in_use_is_reachable_whenever_its_plug_is_pulled() {
    for seed in 1..=2 {
        let mut random = generator(seed);
        let mut service = Service::new(u32::from(seed));
        let first = any_settings(&mut random);
        service.put_into_service(first).unwrap();
        service.plug_in(first);
        let lives = (0..100).map(|_| live(&mut service, &mut random));
        all_kinds(&lives.collect::<Vec<_>>());
    }
}

#[test]
fn a_drive_from_the_factory_is_reachable_whenever_its_plug_is_pulled() {
    let mut random = generator(3);
    let lives = (0..100).map(|serial_number| {
        let mut service = Service::new(serial_number);
        let end = live(&mut service, &mut random);
        // Whatever became of it, it can be put into service now.
        let new = any_settings(&mut random);
        service.put_into_service(new).unwrap();
        service.plug_in(new);
        end
    });
    all_kinds(&lives.collect::<Vec<_>>());
}

#[test]
fn a_cut_at_any_byte_of_a_store_leaves_the_old_setting_or_the_new_one() {
    let [old, new] = [(11, BitRate::Kbit500), (12, BitRate::Kbit125)].map(|(node_id, bit_rate)| {
        let node_id = NodeId::new(node_id).expect("a node-ID");
        Settings { node_id, bit_rate }
    });
    let mut found_old = 0;
    for byte in 1.. {
        let mut service = Service::new(7);
        service.put_into_service(old).unwrap();
        service.plug_in(old);
        let drive = service.master.station_mut(service.drive);
        drive.pull_at_byte(byte);
        let result = service.put_into_service(new);
        service.plug_in(new);
        if result.is_ok() || service.progress > Progress::Storing {
            break;
        }
        found_old += u32::from(service.settings == old);
    }
    // A record has a head, a key, the settings and their checksum.
    assert!(found_old > 8, "only {found_old} cuts left the old setting");
}
