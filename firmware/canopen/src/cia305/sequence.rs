//! Services that take several messages: switch state selective (four) and identify remote slave (six).
//!
//! The messages come in order, with no other LSS service between them. A word that does not fit ends the sequence.

use super::identity::Identity;
use super::request::Request;

/// How far such a service has come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Sequence {
    /// No such service is going on.
    None,
    /// Switch state selective expects this word, 1 to 3.
    Selective(u8),
    /// Identify remote slave expects this word, 1 to 5.
    Identify(u8),
}

impl Sequence {
    /// Any request that does not go on with the service in progress ends it, answered or not.
    pub(super) fn hear(&mut self, request: Option<&Request>) {
        let goes_on = matches!(
            (*self, request),
            (Self::Selective(_), Some(Request::SwitchSelective { .. }))
                | (Self::Identify(_), Some(Request::Identify { .. }))
        );
        if !goes_on {
            *self = Self::None;
        }
    }

    /// Takes a word of switch state selective; returns whether it was the last and all of them fit.
    pub(super) fn select(&mut self, step: u8, word: u32, identity: &Identity) -> bool {
        let is_expected = step == 0 || *self == Self::Selective(step);
        let fits = identity.words().get(usize::from(step)) == Some(&word);
        self.advance(
            is_expected && fits,
            step == 3,
            Self::Selective(step.wrapping_add(1)),
        )
    }

    /// Takes a word of identify remote slave; returns whether it was the last and all of them fit.
    pub(super) fn identify(&mut self, step: u8, word: u32, identity: &Identity) -> bool {
        let is_expected = step == 0 || *self == Self::Identify(step);
        let fits = match step {
            0 => identity.vendor_id == word,
            1 => identity.product_code == word,
            2 => identity.revision_number >= word,
            3 => identity.revision_number <= word,
            4 => identity.serial_number >= word,
            5 => identity.serial_number <= word,
            _ => false,
        };
        self.advance(
            is_expected && fits,
            step == 5,
            Self::Identify(step.wrapping_add(1)),
        )
    }

    /// Goes on to `next` after a good word that is not the last.
    fn advance(&mut self, is_good: bool, is_last: bool, next: Self) -> bool {
        *self = if is_good && !is_last {
            next
        } else {
            Self::None
        };
        is_good && is_last
    }
}
