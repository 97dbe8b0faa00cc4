//! `axis402 lss bitrate` and `lss store`: the whole bus goes to another bit rate, and keeps it (CiA 305).
//!
//! Nothing is stored before everybody is heard at the new bit rate. Until then power-on brings all devices back to the rate that they
//! had, so no mistake on the way leaves a bus with two rates for good.

use canopen::{BitRate, Duration};

use super::lss::{STORE_TIME, silence, waiting_afterwards};
use super::{Console, Problem, scan};
use crate::{Failure, Line, Master};

/// How the bus is switched.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BitRateSwitch {
    /// To which bit rate.
    pub to: BitRate,
    /// The bit rate now, which all devices get again if one of them refuses; `None` if it is not known.
    pub from: Option<BitRate>,
    /// Whether the devices store it.
    pub store: bool,
    /// The silence before and after the switch, in whole milliseconds.
    pub delay: Duration,
}

/// Switches the whole bus to another bit rate: all devices, and the adapter of this master. Lets them store it when all of them are
/// there again.
///
/// # Errors
/// [`Problem::Failed`] if nobody answers or somebody refuses; then all stay where they are. Also if a node does not come along, or
/// does not store.
pub fn switch_bit_rate<L: Line>(
    master: &mut Master<L>,
    switch: BitRateSwitch,
    console: &mut Console<'_>,
) -> Result<(), Problem> {
    // Whoever is left in configuration state without a node-ID boots, or is counted.
    master.lss_switch_to_waiting();
    let before = Present::hear(master, console)?;
    let configured = configure(master, switch, before.count());
    if let Err(problem) = configured {
        return waiting_afterwards(master, |_| Err(problem));
    }
    let kbit = switch.to.kbit_per_second();
    if !activate(master, switch)? {
        let store = if switch.store { "store" } else { "find" };
        return console.say(&format!(
            "the devices are at {kbit} kbit/s until power-off and wait in the LSS configuration state: set the interface to \
             {kbit} kbit/s, then `axis402 lss {store}` ends it"
        ));
    }
    // The nodes are there for everybody again, before they are looked for.
    waiting_afterwards(master, |_| Ok(()))?;
    let after = Present::hear(master, console)?;
    before.expect_all(&after, kbit)?;
    if switch.store {
        store(master, after.count(), console)?;
    }
    let all = before.nodes.len();
    console.say(&format!("at {kbit} kbit/s {all} of {all} nodes answer"))
}

/// Lets all devices store node-ID and bit rate as they have been configured.
///
/// # Errors
/// [`Problem::Failed`] if nobody answers or somebody does not store.
pub fn store_settings<L: Line>(
    master: &mut Master<L>,
    console: &mut Console<'_>,
) -> Result<(), Problem> {
    let present = Present::hear(master, console)?;
    store(master, present.count(), console)?;
    console.say(&match present.nodes.len() {
        0 => "stored".to_owned(),
        1 => "stored, with 1 node on the bus".to_owned(),
        count => format!("stored, with {count} nodes on the bus"),
    })
}

/// Who is on the bus.
#[derive(Debug)]
struct Present {
    nodes: Vec<u8>,
    /// At least one device has no node-ID.
    unconfigured: bool,
}

impl Present {
    fn hear<L: Line>(master: &mut Master<L>, console: &mut Console<'_>) -> Result<Self, Problem> {
        Ok(Self {
            nodes: scan::used(master, console)?,
            unconfigured: master.lss_is_anyone_unconfigured()?,
        })
    }

    /// How many answers to wait for. Devices without a node-ID cannot be counted: then all that come in the time.
    fn count(&self) -> usize {
        match self.nodes.len() {
            count @ 1.. if !self.unconfigured => count,
            _ => usize::MAX,
        }
    }

    /// Everybody who was there before has come along.
    fn expect_all(&self, after: &Self, kbit: u32) -> Result<(), Problem> {
        let lost = self.nodes.iter().filter(|node| !after.nodes.contains(node));
        let mut lost: Vec<_> = lost.map(|node| format!("node {node}")).collect();
        let came = self.nodes.len() - lost.len();
        if self.unconfigured && !after.unconfigured {
            lost.push("the device without a node-ID".to_owned());
        }
        if lost.is_empty() {
            return Ok(());
        }
        Err(Problem::Failed(format!(
            "at {kbit} kbit/s {came} of {} nodes answer, lost: {}; nothing is stored, power-on brings the old bit rate back",
            self.nodes.len(),
            lost.join(", ")
        )))
    }
}

/// Tells all devices the new bit rate. If one refuses, all get the old one again: else the next store would keep the new one in the others.
fn configure<L: Line>(
    master: &mut Master<L>,
    switch: BitRateSwitch,
    count: usize,
) -> Result<(), Problem> {
    master.lss_switch_to_configuration();
    let answers = master
        .lss_ask_all(bit_timing(switch.to), count, master.answer_time())
        .map_err(|failure| silence(failure, "no device answers"))?;
    let Some(error) = first_error(&answers) else {
        return Ok(());
    };
    let refused = Problem::from(Failure::LssRefused {
        service: 0x13,
        error,
    });
    let line = refused.line().unwrap_or_default();
    let Some(from) = switch.from else {
        let kbit = switch.to.kbit_per_second();
        return Err(Problem::Failed(format!(
            "{line}; the others would store {kbit} kbit/s: power them off and on"
        )));
    };
    // Who has refused may do so again: it has nothing to take back.
    master.lss_ask_all(bit_timing(from), count, master.answer_time())?;
    Err(Problem::Failed(format!("{line}; all keep their bit rate")))
}

/// All devices and the adapter change their bit rate; false if the adapter's is not in this program's hands. Whatever happens, nothing
/// is sent at the old bit rate any more: nobody would acknowledge it, and its repetitions would disturb the bus.
fn activate<L: Line>(master: &mut Master<L>, switch: BitRateSwitch) -> Result<bool, Problem> {
    let BitRateSwitch { to, delay, .. } = switch;
    master.lss_activate_bit_timing(delay);
    // The adapter changes in the middle of the silence after the devices have changed.
    master.wait(delay + delay / 2)?;
    let switched = master.line_mut().set_bit_rate(to).map_err(Failure::from)?;
    master.wait(delay)?;
    Ok(switched)
}

/// All devices store.
fn store<L: Line>(
    master: &mut Master<L>,
    count: usize,
    console: &mut Console<'_>,
) -> Result<(), Problem> {
    let answers = waiting_afterwards(master, |master| {
        master.lss_switch_to_configuration();
        // Who refuses may be the last to answer: a drive tries for a while before it says that it cannot.
        master
            .lss_ask_all([0x17, 0, 0, 0, 0, 0, 0, 0], count, STORE_TIME)
            .map_err(|failure| silence(failure, "no device answers"))
    })?;
    if answers.iter().any(|answer| answer[1] == 1) {
        console.remark("a device does not store by LSS: it forgets this at power-off");
    }
    let Some(error) = answers.iter().map(|answer| answer[1]).find(|e| *e > 1) else {
        return Ok(());
    };
    let refused = Problem::from(Failure::LssRefused {
        service: 0x17,
        error,
    });
    Err(Problem::Failed(format!(
        "{}; not all have stored, and power-on would part them: take the power from the motors, then `axis402 lss store`",
        refused.line().unwrap_or_default()
    )))
}

fn bit_timing(bit_rate: BitRate) -> [u8; 8] {
    [0x13, 0, bit_rate.table_index(), 0, 0, 0, 0, 0]
}

fn first_error(answers: &[[u8; 8]]) -> Option<u8> {
    (answers.iter().map(|answer| answer[1])).find(|error| *error != 0)
}
