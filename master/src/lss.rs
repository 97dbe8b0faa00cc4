//! The LSS master (CiA 305): requests on 7E5h, answers on 7E4h.

pub use canopen::cia305::Identity;
use canopen::{BitRate, Duration, Frame, NodeId};

use crate::{Failure, Line, Master};

const REQUEST: u16 = 0x7E5;
const ANSWER: u16 = 0x7E4;

impl<L: Line> Master<L> {
    /// Switches all slaves to the waiting state.
    pub fn lss_switch_to_waiting(&mut self) {
        self.send_data(REQUEST, &[0x04, 0, 0, 0, 0, 0, 0, 0]);
    }

    /// Switches all slaves to the configuration state.
    pub fn lss_switch_to_configuration(&mut self) {
        self.send_data(REQUEST, &[0x04, 1, 0, 0, 0, 0, 0, 0]);
    }

    /// Switches the slave with this identity to the configuration state.
    ///
    /// # Errors
    /// [`Failure::Timeout`] if no slave has it.
    pub fn lss_select(&mut self, identity: Identity) -> Result<(), Failure> {
        for (command, word) in (0x40..).zip(identity.words()) {
            self.send_data(REQUEST, &request(command, word));
        }
        self.lss_answer(0x44, self.answer_time).map(|_| ())
    }

    /// Gives the slave in configuration state a node-ID, in force after switching to waiting (if it had none) or at its
    /// next reset.
    ///
    /// # Errors
    /// [`Failure::LssRefused`] or [`Failure::Timeout`].
    pub fn lss_configure_node_id(&mut self, node_id: NodeId) -> Result<(), Failure> {
        self.lss_configure([0x11, node_id.get(), 0, 0, 0, 0, 0, 0])
    }

    /// Gives the slave in configuration state a bit rate, in force after [`Master::lss_activate_bit_timing`].
    ///
    /// # Errors
    /// [`Failure::LssRefused`] or [`Failure::Timeout`].
    pub fn lss_configure_bit_timing(&mut self, bit_rate: BitRate) -> Result<(), Failure> {
        self.lss_configure([0x13, 0, bit_rate.table_index(), 0, 0, 0, 0, 0])
    }

    /// Lets slaves in configuration state be silent for `delay` (whole milliseconds), switch their bit rate, and be silent
    /// for `delay` again. The master's own rate is the script's to change.
    pub fn lss_activate_bit_timing(&mut self, delay: Duration) {
        let [low, high] = (delay.to_millis() as u16).to_le_bytes();
        self.send_data(REQUEST, &[0x15, low, high, 0, 0, 0, 0, 0]);
    }

    /// Lets the slave in configuration state store node-ID and bit rate.
    ///
    /// # Errors
    /// [`Failure::LssRefused`] or [`Failure::Timeout`].
    pub fn lss_store(&mut self) -> Result<(), Failure> {
        self.lss_configure([0x17, 0, 0, 0, 0, 0, 0, 0])
    }

    /// Asks the slave in configuration state for its identity.
    ///
    /// # Errors
    /// [`Failure::Timeout`].
    pub fn lss_inquire_identity(&mut self) -> Result<Identity, Failure> {
        let mut words = [0; 4];
        for (command, word) in (0x5A..).zip(&mut words) {
            let [_, a, b, c, d, ..] = self.lss_ask(request(command, 0), self.answer_time)?;
            *word = u32::from_le_bytes([a, b, c, d]);
        }
        Ok(words.into())
    }

    /// Asks the slave in configuration state for its node-ID; `None` in the answer's place if it is no valid one.
    ///
    /// # Errors
    /// [`Failure::Timeout`].
    pub fn lss_inquire_node_id(&mut self) -> Result<Option<NodeId>, Failure> {
        let [_, number, ..] = self.lss_ask(request(0x5E, 0), self.answer_time)?;
        Ok(NodeId::new(number))
    }

    /// Asks whether there is a slave without a node-ID (LSS identify non-configured remote slave).
    ///
    /// # Errors
    /// [`Failure::LineDown`] only: silence means that there is none.
    pub fn lss_is_anyone_unconfigured(&mut self) -> Result<bool, Failure> {
        self.forget_answers(0x50);
        self.send_data(REQUEST, &request(0x4C, 0));
        match self.lss_answer(0x50, self.answer_time) {
            Ok(_) => Ok(true),
            Err(Failure::Timeout { .. }) => Ok(false),
            Err(failure) => Err(failure),
        }
    }

    /// Finds one slave without a node-ID by fastscan and leaves it in configuration state. `None` if there is no such slave.
    ///
    /// # Errors
    /// [`Failure::WrongValue`] if a slave stopped answering in the middle.
    pub fn lss_fastscan(&mut self) -> Result<Option<Identity>, Failure> {
        self.lss_fastscan_watched(|_, _| {})
    }

    /// [`Master::lss_fastscan`] that tells `watch` before each question how many have been answered, and how many there are.
    ///
    /// # Errors
    /// As [`Master::lss_fastscan`].
    pub fn lss_fastscan_watched(
        &mut self,
        mut watch: impl FnMut(u32, u32),
    ) -> Result<Option<Identity>, Failure> {
        const QUESTIONS: u32 = 1 + 4 * 33;
        let mut done = 0;
        let mut next_question = || {
            watch(done, QUESTIONS);
            done += 1;
        };
        next_question();
        if !self.scan_step(0, 0x80, 0, 0)? {
            return Ok(None);
        }
        let mut words = [0; 4];
        for (sub, word) in (0..4u8).zip(&mut words) {
            for bit in (0..32u8).rev() {
                next_question();
                // A slave answers if its bit is 0 like the scan's; silence means 1.
                if !self.scan_step(*word, bit, sub, sub)? {
                    *word |= 1 << bit;
                }
            }
            let next = if sub == 3 { 0 } else { sub + 1 };
            next_question();
            if !self.scan_step(*word, 0, sub, next)? {
                return Err(Failure::WrongValue {
                    expected: format!("a slave with {word:08X}h in 1018h:{}", sub + 1),
                    got: "none".to_owned(),
                });
            }
        }
        Ok(Some(words.into()))
    }

    /// Sends any LSS request and waits for the answer with the same command specifier.
    ///
    /// # Errors
    /// [`Failure::Timeout`] if none came `within` the time.
    pub fn lss_ask(&mut self, request: [u8; 8], within: Duration) -> Result<[u8; 8], Failure> {
        self.send_data(REQUEST, &request);
        self.lss_answer(request[0], within)
    }

    /// Sends a request to all slaves in configuration state and hears `count` answers, or what comes `within` the time: answers
    /// that are the same may merge into one on the bus.
    ///
    /// # Errors
    /// [`Failure::Timeout`] if none came.
    pub fn lss_ask_all(
        &mut self,
        request: [u8; 8],
        count: usize,
        within: Duration,
    ) -> Result<Vec<[u8; 8]>, Failure> {
        self.forget_answers(request[0]);
        let end = self.now() + within;
        let mut answers = vec![self.lss_ask(request, within)?];
        while answers.len() < count {
            // Answers that never end do not keep it waiting.
            let Some(left) = end.checked_duration_since(self.now()) else {
                break;
            };
            match self.lss_answer(request[0], left) {
                Ok(answer) => answers.push(answer),
                Err(Failure::Timeout { .. }) => break,
                Err(failure) => return Err(failure),
            }
        }
        Ok(answers)
    }

    fn lss_configure(&mut self, request: [u8; 8]) -> Result<(), Failure> {
        let [service, error, ..] = self.lss_ask(request, self.answer_time)?;
        if error == 0 {
            Ok(())
        } else {
            Err(Failure::LssRefused { service, error })
        }
    }

    /// One question of the fastscan: whether a slave says that it matches.
    fn scan_step(&mut self, number: u32, bit: u8, sub: u8, next: u8) -> Result<bool, Failure> {
        let [a, b, c, d] = number.to_le_bytes();
        self.send_data(REQUEST, &[0x51, a, b, c, d, bit, sub, next]);
        // One answer is not the end of the step: slaves whose answers did not merge into one frame must not answer for the next.
        self.wait(self.scan_time)?;
        let mut found = false;
        while (self.line.inbox())
            .take_from(0, |frame| answer(frame, 0x4F))
            .is_some()
        {
            found = true;
        }
        Ok(found)
    }

    /// Late answers to this service must not pass for new ones.
    fn forget_answers(&mut self, command: u8) {
        while (self.line.inbox())
            .take_from(0, |frame| answer(frame, command))
            .is_some()
        {}
    }

    fn lss_answer(&mut self, command: u8, within: Duration) -> Result<[u8; 8], Failure> {
        let expected = format!("LSS answer {command:02X}");
        self.wait_for(&expected, within, |frame| answer(frame, command))
    }
}

fn request(command: u8, word: u32) -> [u8; 8] {
    let [a, b, c, d] = word.to_le_bytes();
    [command, a, b, c, d, 0, 0, 0]
}

fn answer(frame: &Frame, command: u8) -> Option<[u8; 8]> {
    let payload = frame.full_payload()?;
    (frame.standard_id() == Some(ANSWER) && payload[0] == command).then_some(*payload)
}
