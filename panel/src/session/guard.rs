//! The heartbeat of the panel guards the drive: an entry of 1016h (consumer heartbeat time, CiA 301) is set up before the drive is
//! commanded, and put back when the panel leaves it. What the drive does when the heartbeat ends, its 6007h says.

use master::axis402::{Node, Problem};
use master::data_sheet::Address;
use master::{Failure, Line};

use super::Session;
use crate::message::Guard;

/// The drive counts the panel as lost after this silence, in milliseconds: five heartbeats.
const LOST_AFTER: u32 = 500;

/// An entry of 1016h that the panel has changed, and what stood in it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Guarding {
    sub: u8,
    before: u32,
}

impl<L: Line> Session<L> {
    /// Has the drive watch the panel, if it can.
    pub(super) fn ensure_guard(&mut self) -> Result<(), Problem> {
        let own = self.setup.own_node;
        let Some(chosen) = self
            .chosen
            .as_ref()
            .filter(|chosen| chosen.guarding.is_none())
        else {
            return Ok(());
        };
        let node = chosen.node.clone();
        let guard = if self.traffic.node(own).is_some() {
            let taken = format!("node-ID {own}, the panel's, is another node's");
            (None, Guard::Impossible(taken))
        } else {
            match self.set_up_guard(&node, own) {
                Ok(Some(guarding)) => (Some(guarding), Guard::On),
                Ok(None) => {
                    let full = "no entry of 1016h is free".to_owned();
                    (None, Guard::Impossible(full))
                }
                Err(failure @ Failure::Abort { .. }) => {
                    let why = Problem::with_node(node.id, failure).line();
                    (None, Guard::Impossible(why.unwrap_or_default()))
                }
                Err(failure) => return Err(Problem::with_node(node.id, failure)),
            }
        };
        if let Some(chosen) = &mut self.chosen {
            (chosen.guarding, chosen.drive.guard) = guard;
        }
        Ok(())
    }

    fn set_up_guard(&mut self, node: &Node, own: u8) -> Result<Option<Guarding>, Failure> {
        let number = |bytes: Vec<u8>| {
            let bytes = bytes.iter().rev();
            bytes.fold(0u32, |number, byte| number << 8 | u32::from(*byte))
        };
        let entry = |sub| Address::new(0x1016, sub);
        let count = number(node.upload(&mut self.master, entry(0))?).min(127);
        let mut free = None;
        for sub in (1..).take(count as usize) {
            let before = number(node.upload(&mut self.master, entry(sub))?);
            // One of an earlier panel that could not put it back.
            if before >> 16 & 0x7F == u32::from(own) {
                free = Some(Guarding { sub, before: 0 });
                break;
            }
            let is_free = before & 0xFFFF == 0 || before >> 16 & 0x7F == 0;
            if is_free && free.is_none() {
                free = Some(Guarding { sub, before });
            }
        }
        let Some(guarding) = free else {
            return Ok(None);
        };
        let wanted = u32::from(own) << 16 | LOST_AFTER;
        node.download(&mut self.master, entry(guarding.sub), &wanted.to_le_bytes())?;
        self.master.line_mut().set_heartbeat(Some(own));
        Ok(Some(guarding))
    }

    /// Puts 1016h back as it was, and ends the heartbeat.
    pub(super) fn put_guard_back(&mut self) {
        let Some(chosen) = &mut self.chosen else {
            return;
        };
        chosen.drive.guard = Guard::Off;
        if let Some(guarding) = chosen.guarding.take() {
            let node = chosen.node.clone();
            if let Err(failure) = self.put_back(&node, guarding) {
                let why = Problem::with_node(node.id, failure)
                    .line()
                    .unwrap_or_default();
                self.state.notice = Some(format!("1016h was not put back: {why}"));
            }
        }
        self.master.line_mut().set_heartbeat(None);
    }

    /// What somebody else has written there since stays.
    fn put_back(&mut self, node: &Node, guarding: Guarding) -> Result<(), Failure> {
        let entry = Address::new(0x1016, guarding.sub);
        let own = u32::from(self.setup.own_node) << 16 | LOST_AFTER;
        if node.upload(&mut self.master, entry)? == own.to_le_bytes() {
            node.download(&mut self.master, entry, &guarding.before.to_le_bytes())?;
        }
        Ok(())
    }

    /// The entry of 1016h that the panel has at a node, and what it puts back there.
    pub(super) fn guarded_entry(&self, id: u8) -> Option<(Address, u32)> {
        let chosen = self.chosen.as_ref().filter(|chosen| chosen.node.id == id)?;
        let Guarding { sub, before } = chosen.guarding?;
        Some((Address::new(0x1016, sub), before))
    }

    /// Writes or stores the configuration of a node. The entry of the panel is no part of it: it is out meanwhile.
    pub(super) fn without_guard<T>(
        &mut self,
        id: u8,
        work: impl FnOnce(&mut Self) -> Result<T, Problem>,
    ) -> Result<T, Problem> {
        if self.guarded_entry(id).is_none() {
            return work(self);
        }
        self.put_guard_back();
        let result = work(self);
        // A drive that is to be stopped stands before it is commanded again, and then it is guarded again.
        if !self.master.line_mut().urgent().any() {
            self.ensure_guard()?;
        }
        result
    }

    /// A drive that has started anew knows nothing of the panel: 1016h is as it was stored, and the motor has no power.
    pub(super) fn mind_boot(&mut self) {
        let Some(chosen) = &mut self.chosen else {
            return;
        };
        if !self.traffic.take_boot(chosen.node.id) {
            return;
        }
        chosen.guarding = None;
        chosen.has_enabled = false;
        chosen.drive.guard = Guard::Off;
        self.live = None;
        // What was not stored is not set any more.
        self.state.tunings += 1;
        self.master.line_mut().set_heartbeat(None);
    }
}
