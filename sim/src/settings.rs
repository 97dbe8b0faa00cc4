//! Settings that a drive has from the factory, as the builder of a machine delivers it: what its data sheet has by default is changed by
//! these before anything that was stored. So what a user stores counts, and what he restores (1011h) is the factory's again.

use canopen::Configuration;
use canopen::cia301::parameters::{CHUNK, ParameterSet, ParameterSets, ParameterStore};
use canopen::node::StoreError;
use od_gen::model::Access;
use od_gen::{DataType, transfer};
use runtime::Storage;

use crate::flash::{Contents, Flash, ParameterStore as FlashStore};
use master::data_sheet::{Address, DataSheet};

/// The first object that can be set so; those before it belong to the network.
const FIRST: u16 = 0x2000;

/// Bytes of a record before its value: index, sub-index, length.
const HEADER: usize = 4;

/// Values of some objects.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Settings {
    /// Address and value as it travels, in the order of the addresses.
    values: Vec<(Address, Vec<u8>)>,
}

impl Settings {
    /// Sets an object, named as people do (`2032h`, `2040h:1`, `Brake release time`).
    ///
    /// # Errors
    /// There is no such object, it cannot be set so, or not to this number.
    pub fn set(&mut self, sheet: &DataSheet, name: &str, number: i64) -> Result<(), String> {
        let address = sheet.find(name)?;
        let entry = sheet
            .entry(address.index, address.sub)
            .ok_or_else(|| format!("there is no object `{name}` in {}", sheet.title()))?;
        let is_setting = entry.access == Access::ReadWrite && entry.storage.is_some();
        let is_number = !matches!(
            entry.data_type,
            DataType::Domain | DataType::VisibleString | DataType::OctetString
        );
        if address.index < FIRST || !is_setting || !is_number {
            return Err(format!("`{name}` is no setting of a drive"));
        }
        let (low, high) = entry.integer_limits();
        let wide = i128::from(number);
        if low.is_some_and(|low| wide < low) || high.is_some_and(|high| wide > high) {
            return Err(format!("`{name}` = {number} is beyond its limits"));
        }
        let value = transfer::parse(&number.to_string(), entry.data_type)
            .map_err(|problem| format!("`{name}` = {number}: {problem}"))?;
        let bytes = transfer::bytes(&value, entry.data_type, 0);
        match self
            .values
            .binary_search_by_key(&address, |(place, _)| *place)
        {
            Ok(_) => Err(format!("`{name}` is set twice")),
            Err(place) => {
                self.values.insert(place, (address, bytes));
                Ok(())
            }
        }
    }

    /// The address and the bytes of each.
    pub fn values(&self) -> &[(Address, Vec<u8>)] {
        &self.values
    }

    /// As a store has them: records of index, sub-index, length and value, which do not cross the end of a chunk.
    fn chunks(&self) -> Vec<Vec<u8>> {
        let mut chunks: Vec<Vec<u8>> = Vec::new();
        for (address, value) in &self.values {
            let [low, high] = address.index.to_le_bytes();
            let length = u8::try_from(value.len()).unwrap_or(u8::MAX);
            let mut record = vec![low, high, address.sub, length];
            record.extend(value);
            match chunks.last_mut() {
                Some(chunk) if chunk.len() + HEADER + value.len() <= CHUNK => chunk.extend(record),
                _ => chunks.push(record),
            }
        }
        chunks
    }
}

/// A store as a drive with such settings sees it: they are read before everything that is stored.
#[derive(Debug)]
pub(crate) struct FactoryStore {
    store: FlashStore,
    chunks: Vec<Vec<u8>>,
    /// Node-ID and bit rate for the first power-on, and for later ones as long as nothing is stored.
    given: Option<Configuration>,
    is_first: bool,
    /// The flash holds something else, which stays there: parameters are lost for good.
    is_foreign: bool,
}

/// The set that is loaded first.
const FIRST_SET: ParameterSet = ParameterSet::ALL[0];

impl FactoryStore {
    pub(crate) fn new(
        store: FlashStore,
        settings: Option<&Settings>,
        given: Option<Configuration>,
    ) -> Self {
        let flash = store.release();
        let is_foreign = flash.contents() == Contents::Foreign;
        Self {
            store: flash.into_store(),
            is_foreign,
            chunks: settings.map(Settings::chunks).unwrap_or_default(),
            given,
            is_first: true,
        }
    }

    /// The flash below, to break it.
    pub(crate) fn with_flash(&mut self, change: impl FnOnce(&mut Flash)) {
        let empty = Flash::in_memory().into_store();
        let mut flash = std::mem::replace(&mut self.store, empty).release();
        change(&mut flash);
        self.store = flash.into_store();
    }

    /// How many chunks are ahead of those that are stored.
    fn ahead(&self, set: ParameterSet) -> u16 {
        if set == FIRST_SET {
            u16::try_from(self.chunks.len()).unwrap_or(u16::MAX)
        } else {
            0
        }
    }
}

impl Storage for FactoryStore {
    fn load(&mut self) -> Result<Option<Configuration>, StoreError> {
        // What cannot be read counts as empty.
        let stored = Storage::load(&mut self.store).ok().flatten();
        Ok(if std::mem::take(&mut self.is_first) {
            self.given.or(stored)
        } else {
            stored.or(self.given)
        })
    }

    fn save(&mut self, settings: &Configuration) -> Result<(), StoreError> {
        Storage::save(&mut self.store, settings)
    }

    fn forget(&mut self) -> Result<(), StoreError> {
        Storage::forget(&mut self.store)
    }

    fn serial_number(&mut self) -> Option<u32> {
        Storage::serial_number(&mut self.store)
    }
}

impl ParameterStore for FactoryStore {
    fn begin(&mut self, sets: ParameterSets) -> Result<(), StoreError> {
        self.store.begin(sets)
    }

    fn append(&mut self, set: ParameterSet, chunk: &[u8]) -> Result<(), StoreError> {
        self.store.append(set, chunk)
    }

    fn commit(&mut self) -> Result<(), StoreError> {
        self.store.commit()
    }

    fn open(&mut self, set: ParameterSet) -> Result<u16, StoreError> {
        if self.is_foreign {
            return Err(StoreError::Medium);
        }
        Ok(self.ahead(set) + self.store.open(set)?)
    }

    fn read(
        &mut self,
        set: ParameterSet,
        number: u16,
        chunk: &mut [u8; CHUNK],
    ) -> Result<usize, StoreError> {
        let ahead = self.ahead(set);
        match self.chunks.get(usize::from(number)) {
            Some(own) if number < ahead => {
                chunk[..own.len()].copy_from_slice(own);
                Ok(own.len())
            }
            _ => self.store.read(set, number - ahead, chunk),
        }
    }

    fn keep_serial_number(&mut self, number: u32) -> Result<(), StoreError> {
        self.store.keep_serial_number(number)
    }
}
