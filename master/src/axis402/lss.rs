//! `axis402 lss`: find devices without a node-ID, number them, set node-ID and bit rate (CiA 305).

use canopen::{BitRate, Duration, NodeId};

use super::{Console, Problem, scan};
use crate::{Failure, Identity, Line, Master};

/// How often a fastscan is tried: on a busy bus an answer may be late, and the scan is misled.
const ATTEMPTS: u32 = 4;

/// How often a command begins a fastscan anew in all. With [`MOST`] devices it so is over in five and a half minutes of scans, whatever
/// they answer; each that is numbered takes [`STORE_TIME`] and [`BOOT_TIME`] at most beside its scan.
const REPETITIONS: u32 = 24;

/// Devices that are looked for: one more than can have a node-ID.
const MOST: usize = 128;

/// How long a device may take to boot.
const BOOT_TIME: Duration = Duration::from_ticks(3_000_000);

/// How long a device may take to store; erasing flash takes its time.
pub(super) const STORE_TIME: Duration = Duration::from_ticks(5_000_000);

/// How to number devices.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Numbering {
    /// The lowest node-ID to give, 1 to 127.
    pub first: u8,
    /// Whether the devices store it.
    pub store: bool,
}

/// What one device shall be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Setting {
    /// Which device; `None` for the only one on the bus.
    pub device: Option<Identity>,
    /// Its node-ID.
    pub node_id: Option<NodeId>,
    /// Its bit rate at the next power-on.
    pub bit_rate: Option<BitRate>,
    /// Whether it stores them.
    pub store: bool,
}

/// Finds every device without a node-ID, and leaves them as they are.
///
/// # Errors
/// [`Problem::Failed`] if a device answers in riddles, or the bus cannot be used.
pub fn find<L: Line>(master: &mut Master<L>, console: &mut Console<'_>) -> Result<(), Problem> {
    // A device that somebody has left in configuration state is not heard in a scan.
    master.lss_switch_to_waiting();
    waiting_afterwards(master, |master| {
        let mut search = Search::default();
        // A device that was found is in configuration state and takes no part in the next scan.
        while let Some(identity) = search.next(master, console)? {
            console.say(&format!("{}: {identity}", search.found.len()))?;
        }
        console.say(&match search.found.len() {
            0 => "no device without a node-ID".to_owned(),
            1 => "1 device without a node-ID".to_owned(),
            count => format!("{count} devices without a node-ID"),
        })
    })
}

/// Gives each device without a node-ID the lowest one that nobody has.
///
/// # Errors
/// [`Problem::Failed`] if a device refuses or does not boot, or node-IDs run out.
pub fn number<L: Line>(
    master: &mut Master<L>,
    numbering: Numbering,
    console: &mut Console<'_>,
) -> Result<(), Problem> {
    // A device that somebody has left in configuration state is not heard in a scan.
    master.lss_switch_to_waiting();
    let used = scan::used(master, console)?;
    let mut free = (numbering.first..=127).filter(|id| !used.contains(id));
    waiting_afterwards(master, |master| {
        let mut search = Search::default();
        while let Some(identity) = search.next(master, console)? {
            let node_id = (free.next()).and_then(NodeId::new).ok_or_else(|| {
                Problem::Failed(format!("no node-ID is left for the device with {identity}"))
            })?;
            master.lss_configure_node_id(node_id)?;
            if numbering.store {
                store(master, console)?;
            }
            master.lss_switch_to_waiting();
            expect_boot_up(master, node_id)?;
            console.say(&format!("node {}: {identity}", node_id.get()))?;
        }
        console.say(&match search.found.len() {
            0 => "no device without a node-ID".to_owned(),
            1 => "1 device has a node-ID now".to_owned(),
            count => format!("{count} devices have a node-ID now"),
        })
    })
}

/// Sets node-ID or bit rate of one device.
///
/// # Errors
/// [`Problem::Failed`] if the device is not there or refuses.
pub fn set<L: Line>(
    master: &mut Master<L>,
    setting: Setting,
    console: &mut Console<'_>,
) -> Result<(), Problem> {
    master.lss_switch_to_waiting();
    waiting_afterwards(master, |master| {
        match setting.device {
            Some(identity) => (master.lss_select(identity))
                .map_err(|failure| silence(failure, &format!("no device has {identity}")))?,
            None => master.lss_switch_to_configuration(),
        }
        let before = (master.lss_inquire_node_id())
            .map_err(|failure| silence(failure, "no device answers"))?;
        if setting.device.is_none() {
            is_the_only_one(master)?;
        }
        if let Some(node_id) = setting.node_id {
            master.lss_configure_node_id(node_id)?;
        }
        if let Some(bit_rate) = setting.bit_rate {
            master.lss_configure_bit_timing(bit_rate)?;
        }
        if setting.store {
            store(master, console)?;
        }
        master.lss_switch_to_waiting();
        if let Some(node_id) = setting.node_id {
            let number = node_id.get();
            match before.filter(|before| *before != NodeId::UNCONFIGURED) {
                None => {
                    expect_boot_up(master, node_id)?;
                    console.say(&format!("node {number} has booted"))?;
                }
                Some(before) => console.say(&format!(
                    "node {} will be node {number} when its communication is reset",
                    before.get()
                ))?,
            }
        }
        if let Some(bit_rate) = setting.bit_rate {
            let kbit = bit_rate.kbit_per_second();
            console.say(&format!("{kbit} kbit/s count from the next power-on"))?;
        }
        Ok(())
    })
}

/// Two devices with one node-ID would be the end of both.
fn is_the_only_one<L: Line>(master: &mut Master<L>) -> Result<(), Problem> {
    master.take_received();
    let mut serial_numbers = Vec::new();
    // Answers that are different do not merge, and two devices of one product differ in their serial numbers.
    master.send_data(0x7E5, &[0x5D, 0, 0, 0, 0, 0, 0, 0]);
    master.wait(Duration::from_ticks(50_000))?;
    for (_, frame) in master.take_received() {
        if let (Some(0x7E4), Some([0x5D, a, b, c, d, ..])) =
            (frame.standard_id(), frame.full_payload())
        {
            serial_numbers.push(u32::from_le_bytes([*a, *b, *c, *d]));
        }
    }
    match *serial_numbers {
        [_, _, ..] => Err(Problem::Failed(
            "more than one device answers: say which one with --identity".to_owned(),
        )),
        _ => Ok(()),
    }
}

/// Does something with devices in configuration state; they are in waiting state afterwards, whatever became of it.
pub(super) fn waiting_afterwards<L: Line, T>(
    master: &mut Master<L>,
    work: impl FnOnce(&mut Master<L>) -> Result<T, Problem>,
) -> Result<T, Problem> {
    let result = work(master);
    master.lss_switch_to_waiting();
    // So that it is on the bus before anything else is done.
    let sent = master.wait(Duration::from_ticks(10_000));
    let result = result?;
    sent?;
    Ok(result)
}

/// A search for devices without a node-ID, one after the other.
#[derive(Debug, Default)]
struct Search {
    found: Vec<Identity>,
    repetitions: u32,
}

impl Search {
    /// The next of them, in configuration state.
    fn next<L: Line>(
        &mut self,
        master: &mut Master<L>,
        console: &mut Console<'_>,
    ) -> Result<Option<Identity>, Problem> {
        let usual = master.scan_time();
        let scanned = self.scan(master, console);
        master.set_scan_time(usual);
        let Some(identity) = scanned? else {
            return Ok(None);
        };
        let is_again = self.found.contains(&identity);
        self.found.push(identity);
        if is_again || self.found.len() > MOST {
            return Err(Failure::Endless {
                what: format!("the search, with {identity} again,"),
                limit: format!("{} devices", self.found.len()),
            }
            .into());
        }
        Ok(Some(identity))
    }

    /// A fastscan, once more and slower where the answers make no sense.
    fn scan<L: Line>(
        &mut self,
        master: &mut Master<L>,
        console: &mut Console<'_>,
    ) -> Result<Option<Identity>, Failure> {
        let usual = master.scan_time();
        let what = format!("looking for device {}", self.found.len() + 1);
        let mut attempt = 1;
        loop {
            master.take_received();
            let result = master.lss_fastscan_watched(|done, of| console.progress(&what, done, of));
            let is_misled = matches!(result, Err(Failure::WrongValue { .. }));
            if !is_misled || attempt == ATTEMPTS || self.repetitions == REPETITIONS {
                return result;
            }
            master.set_scan_time(usual * 2u32.pow(attempt));
            attempt += 1;
            self.repetitions += 1;
            console.remark("the answers make no sense, once more and slower");
        }
    }
}

fn store<L: Line>(master: &mut Master<L>, console: &mut Console<'_>) -> Result<(), Problem> {
    let usual = master.set_answer_time(STORE_TIME);
    let result = master.lss_store();
    master.set_answer_time(usual);
    match result {
        Err(Failure::LssRefused { error: 1, .. }) => {
            console.remark("the device does not store by LSS: it forgets this at power-off");
            Ok(())
        }
        other => Ok(other?),
    }
}

fn expect_boot_up<L: Line>(master: &mut Master<L>, node_id: NodeId) -> Result<(), Problem> {
    let number = node_id.get();
    let result = master.expect_boot_up(number, BOOT_TIME);
    result.map_err(|failure| silence(failure, &format!("node {number} does not boot")))
}

/// What it means that nothing came; any other failure as it is.
pub(super) fn silence(failure: Failure, meaning: &str) -> Problem {
    match failure {
        Failure::Timeout { .. } => Problem::Failed(meaning.to_owned()),
        other => other.into(),
    }
}
