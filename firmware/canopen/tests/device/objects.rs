//! A small object dictionary, written as a list; offsets are computed when this is compiled.

use canopen::od::{Attributes, Count, DataType, Dictionary, Entry, StorageGroup, Table, buckets};

/// One line of the list.
struct Line {
    index: u16,
    sub: u8,
    data_type: DataType,
    attributes: u16,
    default: &'static [u8],
    /// For a string that can be written.
    capacity: usize,
    limits: u16,
}

const RO: u16 = Attributes::READ;
const WO: u16 = Attributes::WRITE;
const RW: u16 = Attributes::READ | Attributes::WRITE;
const CONST: u16 = Attributes::READ | Attributes::ROM | Attributes::CONSTANT;
const STREAMED: u16 = Attributes::STREAMED;
const NODE_ID: u16 = Attributes::NODE_ID;
const MAPPABLE: u16 = RW | Attributes::RPDO | Attributes::TPDO;

const fn line(
    index: u16,
    sub: u8,
    data_type: DataType,
    attributes: u16,
    default: &'static [u8],
) -> Line {
    Line {
        index,
        sub,
        data_type,
        attributes,
        default,
        capacity: 0,
        limits: Entry::NO_LIMITS,
    }
}
const fn u8_(index: u16, sub: u8, attributes: u16, default: &'static [u8; 1]) -> Line {
    line(index, sub, DataType::Unsigned8, attributes, default)
}
const fn u16_(index: u16, sub: u8, attributes: u16, default: &'static [u8; 2]) -> Line {
    line(index, sub, DataType::Unsigned16, attributes, default)
}
const fn u32_(index: u16, sub: u8, attributes: u16, default: &'static [u8; 4]) -> Line {
    line(index, sub, DataType::Unsigned32, attributes, default)
}
const fn text(index: u16, default: &'static str) -> Line {
    line(index, 0, DataType::VisibleString, CONST, default.as_bytes())
}
const fn writable_text(index: u16, default: &'static str, capacity: usize) -> Line {
    Line {
        capacity,
        ..line(index, 0, DataType::VisibleString, RW, default.as_bytes())
    }
}
const fn limited(line: Line, limits: u16) -> Line {
    Line { limits, ..line }
}

macro_rules! communication_parameter {
    ($index:expr, $cob_id:expr) => {
        [
            u8_($index, 0, CONST, &[2]),
            u32_($index, 1, RW | NODE_ID, $cob_id),
            u8_($index, 2, RW, &[255]),
        ]
    };
}
macro_rules! transmit_parameter {
    ($index:expr, $cob_id:expr) => {
        [
            u8_($index, 0, CONST, &[6]),
            u32_($index, 1, RW | NODE_ID, $cob_id),
            u8_($index, 2, RW, &[255]),
            u16_($index, 3, RW, &[0, 0]),
            u16_($index, 5, RW, &[0, 0]),
            u8_($index, 6, RW, &[0]),
        ]
    };
}
macro_rules! mapping_parameter {
    ($index:expr, $first:expr, $second:expr) => {
        [
            u8_($index, 0, RW, &[2]),
            u32_($index, 1, RW, $first),
            u32_($index, 2, RW, $second),
            u32_($index, 3, RW, &[0; 4]),
            u32_($index, 4, RW, &[0; 4]),
            u32_($index, 5, RW, &[0; 4]),
            u32_($index, 6, RW, &[0; 4]),
            u32_($index, 7, RW, &[0; 4]),
            u32_($index, 8, RW, &[0; 4]),
        ]
    };
}

const LISTS: &[&[Line]] = &[
    &[
        u32_(0x1000, 0, CONST, &[0x92, 0x01, 0x02, 0x00]),
        u8_(0x1001, 0, RO | Attributes::TPDO, &[0]),
        u8_(0x1003, 0, RW, &[0]),
        u32_(0x1003, 1, RO, &[0; 4]),
        u32_(0x1003, 2, RO, &[0; 4]),
        u32_(0x1003, 3, RO, &[0; 4]),
        u32_(0x1003, 4, RO, &[0; 4]),
        u32_(0x1003, 5, RO, &[0; 4]),
        u32_(0x1003, 6, RO, &[0; 4]),
        u32_(0x1003, 7, RO, &[0; 4]),
        u32_(0x1003, 8, RO, &[0; 4]),
        u32_(0x1005, 0, RW, &[0x80, 0, 0, 0]),
        u32_(0x1006, 0, RW, &[0; 4]),
        u32_(0x1007, 0, RW, &[0; 4]),
        text(0x1008, "Axis402 test 032"),
        u16_(0x100C, 0, RW, &[0, 0]),
        u8_(0x100D, 0, RW, &[0]),
        u8_(0x1010, 0, CONST, &[4]),
        u32_(0x1010, 1, RW, &[0; 4]),
        u32_(0x1010, 2, RW, &[0; 4]),
        u32_(0x1010, 3, RW, &[0; 4]),
        u32_(0x1010, 4, RW, &[0; 4]),
        u8_(0x1011, 0, CONST, &[4]),
        u32_(0x1011, 1, RW, &[0; 4]),
        u32_(0x1011, 2, RW, &[0; 4]),
        u32_(0x1011, 3, RW, &[0; 4]),
        u32_(0x1011, 4, RW, &[0; 4]),
        u32_(0x1012, 0, RW, &[0, 1, 0, 0]),
        u32_(0x1014, 0, RW | NODE_ID, &[0x80, 0, 0, 0]),
        u16_(0x1015, 0, RW, &[0, 0]),
        u8_(0x1016, 0, CONST, &[3]),
        u32_(0x1016, 1, RW, &[0; 4]),
        u32_(0x1016, 2, RW, &[0; 4]),
        u32_(0x1016, 3, RW, &[0; 4]),
        u16_(0x1017, 0, RW, &[0, 0]),
        u8_(0x1018, 0, CONST, &[4]),
        u32_(0x1018, 1, RO, &[0x44, 0x33, 0x22, 0x11]),
        u32_(0x1018, 2, RO, &[0x88, 0x77, 0x66, 0x55]),
        u32_(0x1018, 3, RO, &[0xCC, 0xBB, 0xAA, 0x99]),
        u32_(0x1018, 4, RO, &[0; 4]),
        u8_(0x1019, 0, RW, &[0]),
        u8_(0x1020, 0, CONST, &[2]),
        u32_(0x1020, 1, RW, &[0; 4]),
        u32_(0x1020, 2, RW, &[0; 4]),
        u8_(0x1028, 0, CONST, &[2]),
        u32_(0x1028, 1, RW, &[0, 0, 0, 0x80]),
        u32_(0x1028, 2, RW, &[0, 0, 0, 0x80]),
        u8_(0x1029, 0, CONST, &[1]),
        u8_(0x1029, 1, RW, &[0]),
        u8_(0x1200, 0, CONST, &[2]),
        u32_(0x1200, 1, RO | NODE_ID, &[0x00, 0x06, 0, 0]),
        u32_(0x1200, 2, RO | NODE_ID, &[0x80, 0x05, 0, 0]),
        u8_(0x1201, 0, CONST, &[3]),
        u32_(0x1201, 1, RW, &[0, 0, 0, 0x80]),
        u32_(0x1201, 2, RW, &[0, 0, 0, 0x80]),
        u8_(0x1201, 3, RW, &[1]),
    ],
    &communication_parameter!(0x1400, &[0x00, 0x02, 0, 0]),
    &communication_parameter!(0x1401, &[0x00, 0x03, 0, 0x80]),
    &mapping_parameter!(0x1600, &[32, 0, 0x03, 0x20], &[32, 0, 0x04, 0x20]),
    &mapping_parameter!(0x1601, &[32, 0, 0x03, 0x20], &[32, 0, 0x04, 0x20]),
    &transmit_parameter!(0x1800, &[0x80, 0x01, 0, 0x40]),
    &transmit_parameter!(0x1801, &[0x80, 0x02, 0, 0xC0]),
    &mapping_parameter!(0x1A00, &[32, 0, 0x05, 0x20], &[32, 0, 0x06, 0x20]),
    &mapping_parameter!(0x1A01, &[32, 0, 0x05, 0x20], &[32, 0, 0x06, 0x20]),
    &[
        u32_(0x1F80, 0, RW, &[4, 0, 0, 0]),
        u32_(0x2000, 0, RW, &[0x78, 0x56, 0x34, 0x12]),
        writable_text(0x2001, "hello", 64),
        u32_(0x2003, 0, MAPPABLE, &[0; 4]),
        u32_(0x2004, 0, MAPPABLE, &[0; 4]),
        u32_(0x2005, 0, MAPPABLE, &[0; 4]),
        u32_(0x2006, 0, MAPPABLE, &[0; 4]),
        line(
            0x2007,
            0,
            DataType::Unsigned64,
            RW,
            &[1, 2, 3, 4, 5, 6, 7, 8],
        ),
        limited(u8_(0x2008, 0, RW, &[15]), 0),
        u16_(0x2009, 0, WO, &[0, 0]),
        limited(line(0x200A, 0, DataType::Integer8, RW, &[0xFF]), 1),
        writable_text(0x200B, "", 32),
        text(0x200C, "123456"),
        text(0x200D, "1234567"),
        text(0x200E, "12345678"),
        text(0x200F, "1234567890123"),
        text(0x2010, "12345678901234"),
        text(0x2011, "123456789012345"),
        text(0x2012, "abc"),
        u16_(0x2013, 0, RW, &[0, 0]),
        line(0x2014, 0, DataType::Domain, RW | STREAMED, &[]),
        line(0x2015, 0, DataType::Domain, RO | STREAMED, &[]),
        writable_text(0x2016, "", 900),
        u32_(0x6081, 0, MAPPABLE, &[10, 0, 0, 0]),
    ],
];

/// The bits of the storage group: what can be read and written, by the range of its index.
const fn storage(line: &Line) -> u16 {
    let group = match line.index {
        0x1003 | 0x1010 | 0x1011 => return 0,
        _ if line.attributes & (RW | Attributes::ROM) != RW => return 0,
        0x1000..=0x1FFF => StorageGroup::Communication,
        0x2000..=0x5FFF => StorageGroup::Manufacturer,
        _ => StorageGroup::Application,
    };
    (group as u16) << Attributes::STORAGE_SHIFT
}

/// 10 to 20, and -5 to 5.
const LIMITS: &[u8] = &[10, 20, 0xFB, 5];

/// Bytes in RAM, bytes in flash, entries.
const fn sizes() -> (usize, usize, usize) {
    let (mut ram, mut rom, mut entries, mut list) = (0, 0, 0, 0);
    while list < LISTS.len() {
        let mut i = 0;
        while i < LISTS[list].len() {
            let line = &LISTS[list][i];
            if line.attributes & Attributes::ROM != 0 {
                rom += line.default.len();
            } else if line.capacity > 0 {
                ram += 2 + line.capacity;
            } else {
                ram += line.default.len();
            }
            entries += 1;
            i += 1;
        }
        list += 1;
    }
    (ram, rom, entries)
}

const RAM: usize = sizes().0;
const ROM: usize = sizes().1;
const ENTRIES: usize = sizes().2;

struct Layout {
    entries: [Entry; ENTRIES],
    defaults: [u8; RAM],
    rom: [u8; ROM],
}

const fn layout() -> Layout {
    let nothing = Entry::new((0, 0), DataType::Boolean, 0, Entry::NO_LIMITS, 0);
    let mut all = Layout {
        entries: [nothing; ENTRIES],
        defaults: [0; RAM],
        rom: [0; ROM],
    };
    let (mut ram, mut rom, mut entry, mut list) = (0, 0, 0, 0);
    while list < LISTS.len() {
        let mut i = 0;
        while i < LISTS[list].len() {
            let line = &LISTS[list][i];
            let in_rom = line.attributes & Attributes::ROM != 0;
            let size = if line.capacity > 0 {
                line.capacity
            } else {
                line.default.len()
            };
            all.entries[entry] = Entry::new(
                (line.index, line.sub),
                line.data_type,
                if in_rom { rom as u16 } else { ram as u16 },
                if line.data_type.is_variable() {
                    size as u16
                } else {
                    line.limits
                },
                line.attributes | storage(line),
            );
            if line.capacity > 0 {
                all.defaults[ram] = line.default.len() as u8;
                ram += 2;
            }
            let mut byte = 0;
            while byte < line.default.len() {
                if in_rom {
                    all.rom[rom + byte] = line.default[byte];
                } else {
                    all.defaults[ram + byte] = line.default[byte];
                }
                byte += 1;
            }
            if in_rom {
                rom += size;
            } else {
                ram += size;
            }
            entry += 1;
            i += 1;
        }
        list += 1;
    }
    all
}

static LAYOUT: Layout = layout();

static TABLE: Table = Table {
    entries: &LAYOUT.entries,
    buckets: &buckets::<128>(&LAYOUT.entries),
    rom: &LAYOUT.rom,
    defaults: &LAYOUT.defaults,
    limits: LIMITS,
    storage: Table::NO_STORAGE,
};

/// The dictionary of the test device.
#[derive(Clone, Debug)]
pub struct Objects([u8; RAM]);

impl Objects {
    /// Full of rubbish until power-on values are loaded.
    pub fn new() -> Self {
        Self([0xEE; RAM])
    }
}

impl Dictionary for Objects {
    type Counts = Count<2, 2, 2, 3, 8, 900>;
    const TABLE: &'static Table = &TABLE;

    fn ram(&self) -> &[u8] {
        &self.0
    }

    fn ram_mut(&mut self) -> &mut [u8] {
        &mut self.0
    }
}
