//! The errors that stand now.

use heapless::Vec;

use super::{Emergency, ErrorRegister, Message};

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
    standing: Vec<Message, MOST_ERRORS>,
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
    pub(super) fn add(&mut self, error: Message) -> bool {
        if self.standing.iter().any(|standing| standing.is_as(error)) {
            return false;
        }
        let register = error.register() | ErrorRegister::GENERIC;
        let error = error.with_register(register);
        if self.standing.push(error).is_err() && !self.add_other(error) {
            return false;
        }
        self.register |= register;
        true
    }

    /// The errors that stand, as history words: the code in the low half.
    pub(super) fn words(&self) -> impl Iterator<Item = u32> {
        let standing = self.standing.iter().map(|error| error.history_word());
        standing.chain(self.others.iter().copied())
    }

    /// The error register.
    pub(super) const fn register(&self) -> u8 {
        self.register
    }

    /// The errors of the list, oldest first.
    pub(super) fn all(&self) -> impl Iterator<Item = Message> {
        self.standing.iter().copied()
    }

    /// Removes the errors that are meant; `false` if there was none.
    pub(super) fn remove(&mut self, meant: Meant) -> bool {
        let number = |errors: &Self| (errors.standing.len(), errors.others.len());
        let before = number(self);
        retain(&mut self.standing, |error| !meant.are(error.history_word()));
        retain(&mut self.others, |word| !meant.are(word));
        let has_removed = number(self) != before;
        if self.standing.is_empty() {
            // The others are only there when the list is full.
            self.others.clear();
            self.other_bits = 0;
        }
        let bits = self.standing.iter().map(|error| error.register());
        self.register = bits.fold(self.other_bits, |all, bits| all | bits);
        has_removed
    }

    /// Adds an error that finds no room in the list; `false` if it stands already.
    #[cold]
    #[inline(never)]
    fn add_other(&mut self, error: Message) -> bool {
        let mut word = error.history_word();
        if self.others.contains(&word) {
            return false;
        }
        if self.others.push(word).is_err() {
            // The oldest falls out.
            for place in self.others.iter_mut().rev() {
                core::mem::swap(place, &mut word);
            }
        }
        self.other_bits |= error.register();
        true
    }
}

/// Keeps these, in their order.
fn retain<T: Copy, const N: usize>(list: &mut Vec<T, N>, keeps: impl Fn(T) -> bool) {
    let mut kept = 0;
    for place in 0..list.len() {
        if let Some(element) = list.get(place).copied().filter(|element| keeps(*element)) {
            if let Some(to) = list.get_mut(kept) {
                *to = element;
            }
            kept = kept.wrapping_add(1);
        }
    }
    list.truncate(kept);
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

    /// Whether the error with this history word is one of them.
    const fn are(self, history_word: u32) -> bool {
        (history_word ^ self.history_word) & self.mask == 0
    }
}
