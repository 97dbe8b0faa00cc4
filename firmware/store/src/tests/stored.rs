//! What a store owes to whoever has written something into it, whatever has happened to its flash since.

use std::vec;
use std::vec::Vec;

use canopen::cia301::parameters::{CHUNK, ParameterSet, ParameterSets, ParameterStore};
use canopen::node::StoreError;
use canopen::{BitRate, BitTiming, Configuration, NodeId};

use super::flash::Flash;
use crate::Store;

/// The chunks of every set, in the order of [`ParameterSet::ALL`].
pub type Contents = [Vec<Vec<u8>>; ParameterSet::COUNT];

/// Chunks that tell which save they are of.
pub fn contents(seed: u8, chunks: usize, length: usize) -> Contents {
    [0, 1, 2, 3].map(|set| {
        let count = if set == 3 { 1 } else { chunks };
        (0..count)
            .map(|chunk| vec![seed ^ (set * 16 + chunk as u8); length])
            .collect()
    })
}

/// Stores these sets as a master does.
///
/// # Errors
/// What the store says.
pub fn save<S: ParameterStore>(
    store: &mut S,
    sets: ParameterSets,
    contents: &Contents,
) -> Result<(), StoreError> {
    store.begin(sets)?;
    for (set, chunks) in ParameterSet::ALL.into_iter().zip(contents) {
        if sets.has(set) {
            for chunk in chunks {
                store.append(set, chunk)?;
            }
        }
    }
    store.commit()
}

/// The chunks of a set.
///
/// # Errors
/// What the store says.
pub fn load_set<S: ParameterStore>(
    store: &mut S,
    set: ParameterSet,
) -> Result<Vec<Vec<u8>>, StoreError> {
    let mut chunks = Vec::new();
    for number in 0..store.open(set)? {
        let mut chunk = [0; CHUNK];
        let length = store.read(set, number, &mut chunk)?;
        chunks.push(chunk[..length].to_vec());
    }
    Ok(chunks)
}

/// Two sectors that soon are full.
pub type Small = Flash<512, 4>;

/// All that a store has; `None` where it says that it was lost.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Stored {
    /// Node-ID and bit rate.
    pub settings: Option<Option<Configuration>>,
    /// The sets, in the order of [`ParameterSet::ALL`].
    pub sets: [Option<Vec<Vec<u8>>>; ParameterSet::COUNT],
    /// The serial number.
    pub serial_number: Option<Option<u32>>,
}

impl Stored {
    /// What is found in this flash.
    pub fn found(bytes: &[u8]) -> Self {
        let mut store = Small::new(0).holding(bytes).store();
        Self {
            settings: store.load().ok(),
            sets: ParameterSet::ALL.map(|set| load_set(&mut store, set).ok()),
            serial_number: store.serial_number().ok(),
        }
    }

    /// Whether each value is `other`'s or told as lost.
    pub fn is_left_of(&self, other: &Self) -> bool {
        let sets = self.sets.iter().zip(&other.sets);
        (self.settings.is_none() || self.settings == other.settings)
            && (self.serial_number.is_none() || self.serial_number == other.serial_number)
            && sets
                .into_iter()
                .all(|(own, other)| own.is_none() || own == other)
    }
}

fn settings(node_id: u8) -> Configuration {
    Configuration {
        node_id: NodeId::new(node_id % 127 + 1).unwrap(),
        bit_timing: BitTiming::Fixed(BitRate::Kbit250),
    }
}

/// Flash in which saves were made.
#[derive(Clone, Debug)]
pub struct Filled {
    /// The flash after the last of them.
    pub flash: Small,
    /// What it held when it was empty, and after each of them.
    pub states: Vec<Stored>,
}

impl Filled {
    /// After so many saves of parameters, and those of settings and serial number between them.
    pub fn new(saves: u8) -> Self {
        let flash = Small::new(2);
        let states = vec![Stored::found(&flash.bytes)];
        let mut filled = Self { flash, states };
        if saves > 0 {
            filled.add(|store| store.save_serial_number(0xCAFE_0402).unwrap());
        }
        for seed in 0..saves {
            let sub = if seed == 0 { 1 } else { seed % 4 + 1 };
            let sets = ParameterSets::of_sub_index(sub).unwrap();
            filled.add(|store| save(store, sets, &contents(seed, 1, 8)).unwrap());
            if seed % 3 == 0 {
                filled.add(|store| store.save(&settings(seed)).unwrap());
            }
        }
        filled
    }

    fn add(&mut self, operation: impl FnOnce(&mut Store<Small>)) {
        let mut store = self.flash.clone().store();
        operation(&mut store);
        self.flash = store.release();
        self.states.push(Stored::found(&self.flash.bytes));
    }

    /// What it held after the last save.
    pub fn last(&self) -> &Stored {
        &self.states[self.states.len() - 1]
    }

    /// Whether this may be found once its bytes have become these: what was there, or told as lost. Where bytes were erased the
    /// newest record may be one that a power cut has left, and what was there before it counts.
    fn leaves(&self, bytes: &[u8], found: &Stored) -> bool {
        let is_erased =
            (self.flash.bytes.iter().zip(bytes)).any(|(then, now)| *then != 0xFF && *now == 0xFF);
        let count = if is_erased { self.states.len() } else { 1 };
        (self.states.iter().rev().take(count)).any(|state| found.is_left_of(state))
    }
}

/// Holds the store on these bytes to its promise, where it was filled `before` they were changed: what is found is what was there, or told
/// as lost; the next save is taken and found, whatever it saves; and if the power goes at one of its bytes (every one of them divided by
/// `step`), there is what there was or what was saved.
///
/// # Panics
/// If it does not keep it.
pub fn hold(bytes: &[u8], before: Option<&Filled>, sub: u8, step: usize) {
    let found = Stored::found(bytes);
    if let Some(before) = before {
        let was = before.last();
        assert!(before.leaves(bytes, &found), "{found:?} where {was:?} was");
    }
    let flash = Small::new(0).holding(bytes);
    let new = contents(0x40, 1, 9);
    let sets = ParameterSets::of_sub_index(sub);
    let own = settings(77);
    let states = flash.cuts(|store| match sets {
        Some(sets) => save(store, sets, &new).unwrap(),
        None => store.save(&own).unwrap(),
    });
    let mut wanted = found.clone();
    match sets {
        Some(sets) => {
            for (number, set) in ParameterSet::ALL.into_iter().enumerate() {
                if sets.has(set) {
                    wanted.sets[number] = Some(new[number].clone());
                }
            }
        }
        None => wanted.settings = Some(Some(own)),
    }
    let last = states.len() - 1;
    // A number that may have been lost is none once the store has begun anew.
    let counts = |now: &Stored, then: &Stored| {
        let serial_number = then.serial_number.or(Some(None));
        now == then
            || *now
                == Stored {
                    serial_number,
                    ..then.clone()
                }
    };
    for (cut, state) in states.iter().enumerate() {
        if cut % step.max(1) != 0 && cut != last {
            continue;
        }
        let now = Stored::found(state);
        let is_new = counts(&now, &wanted);
        assert!(
            is_new || cut < last && counts(&now, &found),
            "cut {cut} of {last}: {now:?} where {found:?} was and {wanted:?} was saved"
        );
    }
}
