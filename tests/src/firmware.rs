//! What a plain device has around its node: an application that keeps the streamed objects, and a store for parameters.

use std::collections::BTreeMap;

use canopen::Application;
use canopen::cia301::sdo::{AbortCode, Completion};
use canopen::od::{Entry, write_u32};

use crate::test_device::Dictionary;
pub use ram_store::RamStore as Store;

// The tests of the device store in the same memory.
#[path = "../../firmware/canopen/tests/device/ram_store.rs"]
mod ram_store;

/// The application of the test device: its DOMAINs.
#[derive(Clone, Debug, Default)]
pub struct Firmware {
    /// The value of each DOMAIN, by index; empty if there is none.
    pub domains: BTreeMap<u16, Vec<u8>>,
    /// What clients have written so far, one to each DOMAIN.
    writing: BTreeMap<u16, Vec<u8>>,
    /// The size of a DOMAIN is not told.
    pub hides_size: bool,
    /// The four words of 1018h, if they are not those of the data sheet.
    pub identity: Option<[u32; 4]>,
}

impl Firmware {
    fn domain(&self, entry: &Entry) -> &[u8] {
        self.domains.get(&entry.index).map_or(&[], Vec::as_slice)
    }
}

impl Application<Dictionary> for Firmware {
    fn size(&mut self, _: &Dictionary, entry: &Entry) -> Result<Option<u32>, AbortCode> {
        let size = self.domain(entry).len() as u32;
        Ok(Some(size).filter(|_| !self.hides_size))
    }

    fn read_at(
        &mut self,
        _: &Dictionary,
        entry: &Entry,
        position: u32,
        into: &mut [u8],
    ) -> Result<usize, AbortCode> {
        let rest = self.domain(entry).iter().skip(position as usize);
        let mut length = 0;
        for (to, from) in into.iter_mut().zip(rest) {
            *to = *from;
            length += 1;
        }
        Ok(length)
    }

    fn begin_write(
        &mut self,
        _: &Dictionary,
        entry: &Entry,
        _: Option<u32>,
    ) -> Result<(), AbortCode> {
        let open = self.writing.insert(entry.index, Vec::new());
        assert_eq!(open, None, "a write begins while another is open");
        Ok(())
    }

    fn write_at(
        &mut self,
        _: &Dictionary,
        entry: &Entry,
        position: u32,
        data: &[u8],
    ) -> Result<(), AbortCode> {
        let bytes = self
            .writing
            .get_mut(&entry.index)
            .expect("a write has begun");
        assert_eq!(bytes.len(), position as usize);
        bytes.extend_from_slice(data);
        Ok(())
    }

    fn end_write(
        &mut self,
        _: &mut Dictionary,
        entry: &Entry,
        length: u32,
    ) -> Result<Completion, AbortCode> {
        let bytes = self.writing.remove(&entry.index);
        let bytes = bytes.expect("a write has begun");
        assert_eq!(bytes.len(), length as usize);
        self.domains.insert(entry.index, bytes);
        Ok(Completion::Now)
    }

    fn abandon_write(&mut self, _: &Dictionary, entry: &Entry) {
        let begun = self.writing.remove(&entry.index);
        assert!(begun.is_some(), "a write has begun");
    }

    fn power_on(&mut self, dictionary: &mut Dictionary) {
        for (sub, word) in (1..).zip(self.identity.into_iter().flatten()) {
            let is_there = write_u32(dictionary, 0x1018, sub, word);
            assert!(is_there, "1018h has four words");
        }
    }
}
