//! How the drive homes: method, speeds, acceleration (CiA 402-2: 6098h, 6099h, 609Ah, 60E3h).

use master::Line;
use master::axis402::{Node, Problem};
use master::data_sheet::Address;

use super::Session;
use super::poll::number;
use crate::homing::{method, standard};
use crate::message::{Answer, Homing};

/// Bit of 6502h: the drive knows homing.
const HOMING: i64 = 1 << 5;

const METHOD: Address = Address::new(0x6098, 0);
const FAST: Address = Address::new(0x6099, 1);
const SLOW: Address = Address::new(0x6099, 2);
const ACCELERATION: Address = Address::new(0x609A, 0);

impl<L: Line> Session<L> {
    /// What of it the drive tells; `None` if it knows no homing.
    pub(super) fn read_homing(
        &mut self,
        node: &Node,
        supported: i64,
    ) -> Result<Option<Homing>, Problem> {
        if supported & HOMING == 0 {
            return Ok(None);
        }
        let chosen = self.value(node, METHOD, true)?.unwrap_or_default() as i8;
        let mut methods = self.methods(node)?;
        if !methods.iter().any(|one| one.number == chosen) {
            methods.insert(0, method(chosen));
        }
        Ok(Some(Homing {
            method: chosen,
            fast: self.value(node, FAST, false)?.unwrap_or_default(),
            slow: self.value(node, SLOW, false)?.unwrap_or_default(),
            acceleration: self.value(node, ACCELERATION, false)?.unwrap_or_default(),
            methods,
        }))
    }

    /// Those of 60E3h; all of the standard where the drive has no such list.
    fn methods(&mut self, node: &Node) -> Result<Vec<crate::homing::Method>, Problem> {
        let list = |sub| Address::new(0x60E3, sub);
        let count = self.value(node, list(0), false)?.unwrap_or_default();
        let mut methods = Vec::new();
        for sub in 1..=count.min(254) as u8 {
            if let Some(one) = self.value(node, list(sub), true)?.filter(|one| *one != 0) {
                methods.push(method(one as i8));
            }
        }
        Ok(if methods.is_empty() {
            standard()
        } else {
            methods
        })
    }

    /// Writes them, and reads back what the drive has made of them.
    pub(super) fn set_homing(&mut self, number: i8, speeds: [u32; 3]) -> Result<Answer, Problem> {
        let node = self.chosen_node()?;
        self.set_entry(&node, METHOD, &[number as u8])?;
        for (address, value) in [FAST, SLOW, ACCELERATION].into_iter().zip(speeds) {
            self.set_entry(&node, address, &value.to_le_bytes())?;
        }
        let supported = self.optional(&node, 0x6502)?.unwrap_or_default();
        let homing = self.read_homing(&node, supported)?;
        if let Some(chosen) = &mut self.chosen {
            chosen.drive.homing = homing;
        }
        Ok(Answer::Text(String::new()))
    }

    fn value(
        &mut self,
        node: &Node,
        address: Address,
        is_signed: bool,
    ) -> Result<Option<i64>, Problem> {
        match node.upload(&mut self.master, address) {
            Ok(bytes) => Ok(Some(number(&bytes, is_signed))),
            Err(master::Failure::Abort { .. }) => Ok(None),
            Err(failure) => Err(Problem::with_node(node.id, failure)),
        }
    }

    fn set_entry(&mut self, node: &Node, address: Address, bytes: &[u8]) -> Result<(), Problem> {
        node.download(&mut self.master, address, bytes)
            .map_err(|failure| Problem::with_node(node.id, failure))
    }
}
