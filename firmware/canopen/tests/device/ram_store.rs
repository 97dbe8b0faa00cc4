//! A parameter store in memory, which never wears out.

use canopen::cia301::parameters::{CHUNK, ParameterSet, ParameterSets, ParameterStore};
use canopen::node::StoreError;

/// The chunks of one set.
pub type Chunks = Vec<Vec<u8>>;

/// Sets in force and sets that were begun.
#[derive(Clone, Debug, Default)]
pub struct RamStore {
    /// What is in force, by set.
    pub sets: [Chunks; ParameterSet::COUNT],
    begun: Option<(ParameterSets, [Chunks; ParameterSet::COUNT])>,
    /// Every call that writes fails.
    pub is_broken: bool,
    /// This set cannot be read.
    pub damaged: Option<ParameterSet>,
    /// Calls that write.
    pub writes: usize,
}

#[allow(dead_code, reason = "not every test needs everything")]
impl RamStore {
    /// The power fails: what was begun and not committed is gone.
    pub fn cut_power(&mut self) {
        self.begun = None;
    }

    fn write(&mut self) -> Result<(), StoreError> {
        self.writes += 1;
        if self.is_broken {
            Err(StoreError::Medium)
        } else {
            Ok(())
        }
    }

    /// The records of a set: index, sub-index, value.
    pub fn records(&self, set: ParameterSet) -> Vec<(u16, u8, Vec<u8>)> {
        let mut records = Vec::new();
        for chunk in &self.sets[set as usize] {
            let mut rest = &chunk[..];
            while let [low, high, sub, length, bytes @ ..] = rest {
                let (value, behind) = bytes.split_at(usize::from(*length));
                records.push((u16::from_le_bytes([*low, *high]), *sub, value.to_vec()));
                rest = behind;
            }
            assert!(rest.is_empty(), "a record crosses the end of a chunk");
        }
        records
    }

    /// Replaces a set by these records, as a firmware with another dictionary may have stored them.
    pub fn put(&mut self, set: ParameterSet, records: &[(u16, u8, &[u8])]) {
        self.sets[set as usize] = records
            .iter()
            .map(|(index, sub, value)| {
                let [low, high] = index.to_le_bytes();
                let mut record = vec![low, high, *sub, value.len() as u8];
                record.extend_from_slice(value);
                record
            })
            .collect();
    }
}

impl ParameterStore for RamStore {
    fn begin(&mut self, sets: ParameterSets) -> Result<(), StoreError> {
        self.write()?;
        self.begun = Some((sets, Default::default()));
        Ok(())
    }

    fn append(&mut self, set: ParameterSet, chunk: &[u8]) -> Result<(), StoreError> {
        self.write()?;
        assert!((1..=CHUNK).contains(&chunk.len()));
        let (sets, chunks) = self.begun.as_mut().expect("sets were begun");
        assert!(sets.has(set), "a chunk of another set");
        chunks[set as usize].push(chunk.to_vec());
        Ok(())
    }

    fn commit(&mut self) -> Result<(), StoreError> {
        self.write()?;
        let (sets, mut chunks) = self.begun.take().expect("sets were begun");
        for set in ParameterSet::ALL.into_iter().filter(|set| sets.has(*set)) {
            self.sets[set as usize] = std::mem::take(&mut chunks[set as usize]);
        }
        Ok(())
    }

    fn open(&mut self, set: ParameterSet) -> Result<u16, StoreError> {
        if self.damaged == Some(set) {
            return Err(StoreError::Medium);
        }
        Ok(self.sets[set as usize].len() as u16)
    }

    fn read(
        &mut self,
        set: ParameterSet,
        number: u16,
        chunk: &mut [u8; CHUNK],
    ) -> Result<usize, StoreError> {
        let stored = self.sets[set as usize]
            .get(usize::from(number))
            .ok_or(StoreError::Medium)?;
        chunk[..stored.len()].copy_from_slice(stored);
        Ok(stored.len())
    }
}
