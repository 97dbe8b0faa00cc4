//! The errors that stand now.

use heapless::Vec;

use super::{Emergency, ErrorRegister};

/// Most errors that stand at the same time and each have their bits of the error register.
const MOST_ERRORS: usize = 16;

/// Most errors beyond these that are remembered.
const MOST_OTHERS: usize = 16;

/// One error that stands.
#[derive(Clone, Copy, Debug)]
struct Standing {
    history_word: u32,
    register: u8,
    /// What the history has no room for: the last three bytes of its information.
    rest: [u8; 3],
}

impl Standing {
    fn emergency(&self) -> Emergency {
        let [low, high, a, b] = self.history_word.to_le_bytes();
        let [c, d, e] = self.rest;
        Emergency {
            code: u16::from_le_bytes([low, high]),
            register: self.register,
            info: [a, b, c, d, e],
        }
    }
}

/// The list of errors that stand. One that finds no room in it is told to the master all the same, and once; its bits stay
/// in the error register until no error of the list is left. When there are too many of these as well, the oldest is
/// forgotten, and told again if it is reported again.
#[derive(Debug)]
pub(super) struct ActiveErrors {
    standing: Vec<Standing, MOST_ERRORS>,
    /// The history words of errors without room, oldest first.
    others: Vec<u32, MOST_OTHERS>,
    /// Their bits.
    other_bits: u8,
}

impl ActiveErrors {
    pub(super) const fn new() -> Self {
        Self {
            standing: Vec::new(),
            others: Vec::new(),
            other_bits: 0,
        }
    }

    /// Forgets them all.
    pub(super) fn reset(&mut self) {
        self.standing.clear();
        self.forget_others();
    }

    /// Adds an error; `false` if it stands already.
    pub(super) fn add(&mut self, emergency: &Emergency) -> bool {
        let history_word = emergency.history_word();
        let mut present = self.standing.iter().map(|error| error.history_word);
        if present.any(|word| word == history_word) || self.others.contains(&history_word) {
            return false;
        }
        let register = emergency.register | ErrorRegister::GENERIC;
        let [_, _, rest @ ..] = emergency.info;
        let error = Standing {
            history_word,
            register,
            rest,
        };
        if self.standing.push(error).is_err() {
            self.add_other(history_word);
            self.other_bits |= register;
        }
        true
    }

    /// The errors that stand, as history words: the code in the low half.
    pub(super) fn words(&self) -> impl Iterator<Item = u32> {
        let standing = self.standing.iter().map(|error| error.history_word);
        standing.chain(self.others.iter().copied())
    }

    /// The error register.
    pub(super) fn register(&self) -> u8 {
        self.standing
            .iter()
            .fold(self.other_bits, |bits, error| bits | error.register)
    }

    /// The errors of the list, oldest first.
    pub(super) fn all(&self) -> impl Iterator<Item = Emergency> {
        self.standing.iter().map(Standing::emergency)
    }

    /// Removes the errors that are meant; `false` if there was none.
    pub(super) fn remove(&mut self, meant: Meant) -> bool {
        if self.standing.is_empty() {
            // The others are only there when the list is full.
            return false;
        }
        let is_gone = |word: u32| (word ^ meant.history_word) & meant.mask == 0;
        let number = |errors: &Self| (errors.standing.len(), errors.others.len());
        let before = number(self);
        self.standing.retain(|error| !is_gone(error.history_word));
        self.others.retain(|word| !is_gone(*word));
        let has_removed = number(self) != before;
        if self.standing.is_empty() {
            self.forget_others();
        }
        has_removed
    }

    fn add_other(&mut self, history_word: u32) {
        if self.others.is_full() {
            let mut is_oldest = true;
            self.others
                .retain(|_| !core::mem::replace(&mut is_oldest, false));
        }
        // There is room.
        let _ = self.others.push(history_word);
    }

    fn forget_others(&mut self) {
        self.others.clear();
        self.other_bits = 0;
    }
}

/// Which errors are meant: those whose history word is this one in the bits of the mask.
#[derive(Clone, Copy, Debug)]
pub struct Meant {
    history_word: u32,
    mask: u32,
}

impl Meant {
    /// This error; others with its code stand.
    pub const fn one(emergency: &Emergency) -> Self {
        Self {
            history_word: emergency.history_word(),
            mask: u32::MAX,
        }
    }

    /// Every error with this code, the low half of a history word.
    pub const fn all(code: u16) -> Self {
        Self {
            history_word: code as u32,
            mask: 0xFFFF,
        }
    }
}
