//! The errors that stand now.

use heapless::Vec;

use super::{Emergency, ErrorRegister};

/// Most errors that stand at the same time and each have their bits of the error register.
const MOST_ERRORS: usize = 16;

/// Most errors beyond these that are remembered.
const MOST_OTHERS: usize = 16;

/// The list of errors that stand. One that finds no room in it is told to the master all the same, and once; its bits stay
/// in the error register until no error of the list is left. When there are too many of these as well, the oldest is
/// forgotten, and told again if it is reported again.
#[derive(Debug)]
pub(super) struct ActiveErrors {
    /// Each with its bits of the error register, the generic one among them.
    standing: Vec<Emergency, MOST_ERRORS>,
    /// The history words of errors without room, oldest first.
    others: Vec<u32, MOST_OTHERS>,
    /// Their bits.
    other_bits: u8,
    /// The bits of all.
    register: u8,
}

impl ActiveErrors {
    pub(super) const fn new() -> Self {
        Self {
            standing: Vec::new(),
            others: Vec::new(),
            other_bits: 0,
            register: 0,
        }
    }

    /// Forgets them all.
    pub(super) fn reset(&mut self) {
        self.standing.clear();
        self.others.clear();
        self.other_bits = 0;
        self.register = 0;
    }

    /// Adds an error; `false` if it stands already.
    #[inline(always)]
    pub(super) fn add(&mut self, emergency: &Emergency) -> bool {
        if self.standing.iter().any(|error| error.is_as(emergency)) {
            return false;
        }
        let register = emergency.register | ErrorRegister::GENERIC;
        let error = Emergency {
            register,
            ..*emergency
        };
        if self.standing.push(error).is_err() && !self.add_other(emergency.history_word(), register)
        {
            return false;
        }
        self.register |= register;
        true
    }

    /// The errors that stand, as history words: the code in the low half.
    pub(super) fn words(&self) -> impl Iterator<Item = u32> {
        let standing = self.standing.iter().map(Emergency::history_word);
        standing.chain(self.others.iter().copied())
    }

    /// The error register.
    pub(super) const fn register(&self) -> u8 {
        self.register
    }

    /// The errors of the list, oldest first.
    pub(super) fn all(&self) -> impl Iterator<Item = &Emergency> {
        self.standing.iter()
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
        self.standing.retain(|error| !is_gone(error.history_word()));
        self.others.retain(|word| !is_gone(*word));
        let has_removed = number(self) != before;
        if self.standing.is_empty() {
            self.others.clear();
            self.other_bits = 0;
        }
        let bits = self.standing.iter().map(|error| error.register);
        self.register = bits.fold(self.other_bits, |all, bits| all | bits);
        has_removed
    }

    /// Adds an error that finds no room in the list; `false` if it stands already.
    #[cold]
    #[inline(never)]
    fn add_other(&mut self, history_word: u32, register: u8) -> bool {
        if self.others.contains(&history_word) {
            return false;
        }
        if self.others.is_full() {
            let mut is_oldest = true;
            self.others
                .retain(|_| !core::mem::replace(&mut is_oldest, false));
        }
        // There is room.
        let _ = self.others.push(history_word);
        self.other_bits |= register;
        true
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
