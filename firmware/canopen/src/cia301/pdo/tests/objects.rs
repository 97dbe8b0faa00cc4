//! A small dictionary with four PDOs each way, written by hand.

use crate::od::{Attributes, Count, DataType, Dictionary, Entry, Table, buckets};

const RW: u16 = Attributes::READ | Attributes::WRITE;
const BOTH: u16 = RW | Attributes::RPDO | Attributes::TPDO;
const RO: u16 = Attributes::READ | Attributes::TPDO;

/// A table in the making: entries in ascending order, each behind the one before in RAM.
struct Entries {
    entries: [Entry; 384],
    count: usize,
    ram: u16,
}

impl Entries {
    const fn entry(
        mut self,
        index: u16,
        sub: u8,
        data_type: DataType,
        size: u16,
        attributes: u16,
    ) -> Self {
        let is_rom = attributes & Attributes::ROM != 0;
        let offset = if is_rom {
            (sub as u16 - 1) * 4
        } else {
            self.ram
        };
        let detail = match index {
            _ if data_type.is_variable() => size,
            0x2007 => 0,
            _ => Entry::NO_LIMITS,
        };
        let key = (index, sub);
        self.entries[self.count] = Entry::new(key, data_type, offset, detail, attributes);
        self.count += 1;
        if !is_rom {
            self.ram += if data_type.is_variable() {
                size + 2
            } else {
                size
            };
        }
        self
    }

    /// Four communication records with these sub-indices.
    const fn communication(mut self, index: u16, last_sub: u8) -> Self {
        let mut number = 0;
        while number < 4 {
            let index = index + number;
            self = self
                .entry(index, 0, DataType::Unsigned8, 1, Attributes::READ)
                .entry(index, 1, DataType::Unsigned32, 4, RW)
                .entry(index, 2, DataType::Unsigned8, 1, RW)
                .entry(index, 3, DataType::Unsigned16, 2, RW)
                .entry(index, 5, DataType::Unsigned16, 2, RW);
            if last_sub == 6 {
                self = self.entry(index, 6, DataType::Unsigned8, 1, RW);
            }
            number += 1;
        }
        self
    }

    /// Four mapping records, the last one with as many entries as a frame has bits.
    const fn mapping(mut self, index: u16) -> Self {
        let mut number = 0;
        while number < 4 {
            self = self.entry(index + number, 0, DataType::Unsigned8, 1, RW);
            let mut sub = 1;
            while sub <= if number == 3 { 64 } else { 8 } {
                self = self.entry(index + number, sub, DataType::Unsigned32, 4, RW);
                sub += 1;
            }
            number += 1;
        }
        self
    }
}

const fn entries() -> Entries {
    let unused = Entry::new((0xFFFF, 0xFF), DataType::Unsigned8, 0, Entry::NO_LIMITS, 0);
    let mut table = Entries {
        entries: [unused; 384],
        count: 0,
        ram: 0,
    };
    table = table
        .entry(0x1001, 0, DataType::Unsigned8, 1, RO)
        .entry(0x1005, 0, DataType::Unsigned32, 4, BOTH)
        .entry(
            0x1018,
            1,
            DataType::Unsigned32,
            4,
            RO | Attributes::ROM | Attributes::CONSTANT,
        )
        .entry(
            0x1018,
            2,
            DataType::Unsigned32,
            4,
            RO | Attributes::ROM | Attributes::CONSTANT,
        )
        .communication(0x1400, 5)
        .mapping(0x1600)
        .communication(0x1800, 6)
        .mapping(0x1A00)
        .entry(0x1FA0, 0, DataType::Unsigned8, 1, Attributes::READ)
        .entry(0x1FA0, 1, DataType::Unsigned32, 4, RW)
        .entry(0x1FA0, 2, DataType::Unsigned32, 4, RW)
        .entry(0x1FA1, 1, DataType::Unsigned32, 4, RW)
        .entry(0x1FD0, 0, DataType::Unsigned8, 1, Attributes::READ)
        .entry(0x1FD0, 1, DataType::Unsigned64, 8, RW)
        .entry(0x1FD0, 2, DataType::Unsigned64, 8, RW)
        .entry(0x2000, 0, DataType::Unsigned8, 1, BOTH)
        .entry(0x2001, 0, DataType::Unsigned16, 2, BOTH)
        .entry(0x2002, 0, DataType::Unsigned32, 4, BOTH)
        .entry(0x2003, 0, DataType::Unsigned64, 8, BOTH)
        .entry(0x2004, 0, DataType::Unsigned8, 1, RW)
        .entry(0x2005, 0, DataType::Unsigned8, 1, RO)
        .entry(
            0x2006,
            0,
            DataType::Unsigned8,
            1,
            Attributes::WRITE | Attributes::RPDO,
        )
        .entry(0x2007, 0, DataType::Integer8, 1, BOTH)
        .entry(0x2008, 0, DataType::VisibleString, 8, BOTH)
        .entry(0x2009, 0, DataType::Boolean, 1, BOTH)
        .entry(0x200A, 0, DataType::Integer16, 2, BOTH)
        .entry(0x200B, 0, DataType::Integer32, 4, BOTH);
    let mut sub = 1;
    while sub <= 8 {
        table = table.entry(0x200C, sub, DataType::Unsigned8, 1, BOTH);
        sub += 1;
    }
    table = table.entry(0x200D, 0, DataType::Unsigned48, 6, BOTH).entry(
        0x200E,
        0,
        DataType::Integer24,
        3,
        BOTH,
    );
    sub = 1;
    while sub <= 64 {
        table = table.entry(0x200F, sub, DataType::Boolean, 1, BOTH);
        sub += 1;
    }
    // With a hole: there is no sub-index 2, and nobody may see sub-index 3.
    table
        .entry(0x2010, 1, DataType::Unsigned8, 1, BOTH)
        .entry(0x2010, 3, DataType::Unsigned8, 1, RW)
        .entry(0x2010, 4, DataType::Unsigned8, 1, BOTH)
}

const ALL: Entries = entries();

const ENTRIES: [Entry; ALL.count] = {
    let mut entries = [ALL.entries[0]; ALL.count];
    let mut position = 0;
    while position < ALL.count {
        entries[position] = ALL.entries[position];
        position += 1;
    }
    entries
};

const RAM: usize = ALL.ram as usize;

/// The dictionary.
#[derive(Clone, Debug)]
pub(crate) struct Objects {
    ram: [u8; RAM],
}

impl Dictionary for Objects {
    type Counts = Count<2, 2, 1, 0>;
    const TABLE: &'static Table = &Table {
        entries: &ENTRIES,
        buckets: &buckets::<64>(&ENTRIES),
        rom: &[0x11, 0x22, 0x33, 0x44, 0x55, 0x66, 0x77, 0x88],
        defaults: &[0; RAM],
        limits: &[0xF6, 10],
        storage: Table::NO_STORAGE,
    };

    fn ram(&self) -> &[u8] {
        &self.ram
    }

    fn ram_mut(&mut self) -> &mut [u8] {
        &mut self.ram
    }
}

impl Objects {
    /// All values 0.
    pub(crate) fn new() -> Self {
        Self { ram: [0; RAM] }
    }
}
