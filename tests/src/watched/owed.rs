//! What a device may still send: one boot-up message for a boot, one answer for a request.

use super::Broken;

/// The bookkeeping since power-on.
#[derive(Debug, Default)]
pub(super) struct Owed {
    /// A boot-up message is due, and nothing may be sent before it.
    boot_up: bool,
    /// Answers of the two servers.
    answers: [u32; 2],
    /// The identifiers of these answers.
    cob_ids: [u16; 2],
}

impl Owed {
    /// The device boots: what it owed is forgotten.
    pub(super) fn boot(&mut self) {
        *self = Self {
            boot_up: true,
            ..Self::default()
        };
    }

    /// A request that begins with this byte has come; its answer has this identifier.
    pub(super) fn request(&mut self, server: u16, cob_id: u16, command: u8) {
        // An answer, and what may come by itself: a time-out, and in a block download the acknowledge that asks for more.
        let mut answers = 3;
        // Each step of a block upload may set off a sub-block.
        if command >> 5 == 5 {
            answers += 127;
        }
        if let Some(owed) = self.answers.get_mut(usize::from(server)) {
            *owed += answers;
            self.cob_ids[usize::from(server)] = cob_id;
        }
    }

    /// The server that owes an answer with this identifier.
    pub(super) fn server(&self, cob_id: u16) -> Option<u16> {
        (0..2).find(|server| {
            let server = usize::from(*server);
            self.answers[server] > 0 && self.cob_ids[server] == cob_id
        })
    }

    /// The device sends its boot-up message.
    pub(super) fn boot_up(&mut self) -> Result<(), Broken> {
        if std::mem::take(&mut self.boot_up) {
            Ok(())
        } else {
            Err("a second boot-up message".into())
        }
    }

    /// The device sends something that is not the boot-up message.
    pub(super) fn anything_else(&self) -> Result<(), Broken> {
        if self.boot_up {
            Err("before the boot-up message".into())
        } else {
            Ok(())
        }
    }

    /// A server sends an answer.
    pub(super) fn answer(&mut self, server: u16) -> Result<(), Broken> {
        match self.answers.get_mut(usize::from(server)) {
            Some(owed) if *owed > 0 => {
                *owed -= 1;
                Ok(())
            }
            _ => Err("an answer to no request".into()),
        }
    }
}
