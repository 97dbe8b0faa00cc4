//! A small dictionary written by hand: the communication objects and the drive objects of this crate.

use canopen::od::{Attributes, Count, DataType, Dictionary, Entry, Table, buckets};
use canopen::od::{read_u8, read_u16, read_u32, write_u8, write_u16, write_u32};

use crate::objects::Objects;

const RO: u16 = Attributes::READ | Attributes::TPDO;
const RW: u16 = Attributes::READ | Attributes::WRITE;
const RWW: u16 = RW | Attributes::RPDO;
const ID: u16 = Attributes::NODE_ID;

use DataType::{
    Integer8 as I8, Integer16 as I16, Integer32 as I32, Unsigned8 as U8, Unsigned16 as U16,
    Unsigned32 as U32,
};

/// Index, sub-index, type, attributes, power-on value.
type Object = (u16, u8, DataType, u16, u64);

const OBJECTS: &[Object] = &[
    (0x1000, 0, U32, RO, 0x0004_0192),
    (0x1001, 0, U8, RO, 0),
    (0x1003, 0, U8, RW, 0),
    (0x1003, 1, U32, RO, 0),
    (0x1003, 2, U32, RO, 0),
    (0x1005, 0, U32, RW, 0x80),
    (0x1014, 0, U32, RW | ID, 0x80),
    (0x1015, 0, U16, RW, 0),
    (0x1016, 0, U8, RO, 1),
    (0x1016, 1, U32, RW, 0),
    (0x1017, 0, U16, RW, 0),
    (0x1018, 0, U8, RO, 4),
    (0x1018, 1, U32, RO, 0),
    (0x1018, 2, U32, RO, 0x402),
    (0x1018, 3, U32, RO, 1),
    (0x1018, 4, U32, RO, 0),
    (0x1029, 0, U8, RO, 1),
    (0x1029, 1, U8, RW, 0),
    (0x1400, 0, U8, RO, 2),
    (0x1400, 1, U32, RW | ID, 0x200),
    (0x1400, 2, U8, RW, 255),
    (0x1401, 0, U8, RO, 2),
    (0x1401, 1, U32, RW | ID, 0x300),
    (0x1401, 2, U8, RW, 255),
    (0x1600, 0, U8, RW, 2),
    (0x1600, 1, U32, RW, 0x6040_0010),
    (0x1600, 2, U32, RW, 0x6060_0008),
    (0x1600, 3, U32, RW, 0),
    (0x1600, 4, U32, RW, 0),
    (0x1601, 0, U8, RW, 2),
    (0x1601, 1, U32, RW, 0x6040_0010),
    (0x1601, 2, U32, RW, 0x607A_0020),
    (0x1601, 3, U32, RW, 0),
    (0x1601, 4, U32, RW, 0),
    (0x1800, 0, U8, RO, 5),
    (0x1800, 1, U32, RW | ID, 0x180),
    (0x1800, 2, U8, RW, 255),
    (0x1800, 3, U16, RW, 0),
    (0x1800, 5, U16, RW, 0),
    (0x1801, 0, U8, RO, 5),
    (0x1801, 1, U32, RW | ID, 0x280),
    (0x1801, 2, U8, RW, 1),
    (0x1801, 3, U16, RW, 0),
    (0x1801, 5, U16, RW, 0),
    (0x1A00, 0, U8, RW, 2),
    (0x1A00, 1, U32, RW, 0x6041_0010),
    (0x1A00, 2, U32, RW, 0x6061_0008),
    (0x1A00, 3, U32, RW, 0),
    (0x1A01, 0, U8, RW, 2),
    (0x1A01, 1, U32, RW, 0x6041_0010),
    (0x1A01, 2, U32, RW, 0x6064_0020),
    (0x1A01, 3, U32, RW, 0),
    (0x2020, 0, DataType::Domain, RW | Attributes::STREAMED, 0),
    (0x6007, 0, I16, RW, 3),
    (0x603F, 0, U16, RO, 0),
    (0x6040, 0, U16, RWW, 0),
    (0x6041, 0, U16, RO, 0),
    (0x6042, 0, I16, RWW, 0),
    (0x605A, 0, I16, RW, 2),
    (0x605B, 0, I16, RW, 0),
    (0x605C, 0, I16, RW, 1),
    (0x605D, 0, I16, RW, 1),
    (0x605E, 0, I16, RW, 2),
    (0x6060, 0, I8, RWW, 1),
    (0x6061, 0, I8, RO, 0),
    (0x6062, 0, I32, RO, 0),
    (0x6063, 0, I32, RO, 0),
    (0x6064, 0, I32, RO, 0),
    (0x6067, 0, U32, RW, 10),
    (0x6068, 0, U16, RW, 10),
    (0x606B, 0, I32, RO, 0),
    (0x606C, 0, I32, RO, 0),
    (0x607A, 0, I32, RWW, 0),
    (0x607D, 0, U8, RO, 2),
    (0x607D, 1, I32, RW, 0x8000_0000),
    (0x607D, 2, I32, RW, 0x7FFF_FFFF),
    (0x6081, 0, U32, RWW, 10_000),
    (0x6083, 0, U32, RW, 100_000),
    (0x6084, 0, U32, RW, 100_000),
    (0x6085, 0, U32, RW, 1_000_000),
    (0x60B8, 0, U16, RWW, 0),
    (0x60FE, 0, U8, RO, 2),
    (0x60FE, 1, U32, RWW, 0),
    (0x60FE, 2, U32, RWW, 0),
    (0x60FF, 0, I32, RWW, 0),
    (0x6502, 0, U32, RO, 7),
];

const fn size(data_type: DataType) -> u16 {
    match data_type {
        U8 | I8 => 1,
        U16 | I16 => 2,
        DataType::Domain => 0,
        _ => 4,
    }
}

const RAM: usize = {
    let mut total = 0;
    let mut object = 0;
    while object < OBJECTS.len() {
        total += size(OBJECTS[object].2) as usize;
        object += 1;
    }
    total
};

const fn layout() -> ([Entry; OBJECTS.len()], [u8; RAM]) {
    let blank = Entry::new((0, 0), U8, 0, Entry::NO_LIMITS, 0);
    let mut entries = [blank; OBJECTS.len()];
    let mut defaults = [0; RAM];
    let mut offset = 0;
    let mut object = 0;
    while object < OBJECTS.len() {
        let (index, sub, data_type, attributes, value) = OBJECTS[object];
        let size = size(data_type);
        let key = (index, sub);
        entries[object] = Entry::new(key, data_type, offset, Entry::NO_LIMITS, attributes);
        let mut byte = 0;
        while byte < size {
            defaults[(offset + byte) as usize] = (value >> (8 * byte)) as u8;
            byte += 1;
        }
        offset += size;
        object += 1;
    }
    (entries, defaults)
}

static TABLE: Table = Table {
    entries: &layout().0,
    buckets: &buckets::<256>(&layout().0),
    rom: &[],
    defaults: &layout().1,
    limits: &[],
    storage: Table::NO_STORAGE,
};

#[derive(Debug)]
pub(super) struct DriveDictionary {
    ram: [u8; RAM],
}

impl DriveDictionary {
    pub(super) fn new() -> Self {
        Self { ram: [0; RAM] }
    }

    fn u16(&self, index: u16) -> u16 {
        read_u16(self, index, 0).unwrap()
    }

    fn u32(&self, index: u16, sub: u8) -> u32 {
        read_u32(self, index, sub).unwrap()
    }

    fn put_u16(&mut self, index: u16, value: u16) {
        assert!(write_u16(self, index, 0, value));
    }

    fn put_i32(&mut self, index: u16, value: i32) {
        assert!(write_u32(self, index, 0, value.cast_unsigned()));
    }
}

impl Dictionary for DriveDictionary {
    type Counts = Count<2, 2, 1, 1>;
    const TABLE: &'static Table = &TABLE;

    fn ram(&self) -> &[u8] {
        &self.ram
    }

    fn ram_mut(&mut self) -> &mut [u8] {
        &mut self.ram
    }
}

impl Objects for DriveDictionary {
    type Behaviour = ();

    fn set_error_code(&mut self, value: u16) {
        self.put_u16(0x603F, value);
    }
    fn controlword(&self) -> u16 {
        self.u16(0x6040)
    }
    fn set_statusword(&mut self, value: u16) {
        self.put_u16(0x6041, value);
    }
    fn abort_connection_option_code(&self) -> i16 {
        self.u16(0x6007).cast_signed()
    }
    fn shutdown_option_code(&self) -> i16 {
        self.u16(0x605B).cast_signed()
    }
    fn disable_operation_option_code(&self) -> i16 {
        self.u16(0x605C).cast_signed()
    }
    fn halt_option_code(&self) -> i16 {
        self.u16(0x605D).cast_signed()
    }
    fn fault_reaction_option_code(&self) -> i16 {
        self.u16(0x605E).cast_signed()
    }
    fn quick_stop_option_code(&self) -> i16 {
        self.u16(0x605A).cast_signed()
    }
    fn modes_of_operation(&self) -> i8 {
        read_u8(self, 0x6060, 0).unwrap().cast_signed()
    }
    fn set_modes_of_operation_display(&mut self, value: i8) {
        assert!(write_u8(self, 0x6061, 0, value.cast_unsigned()));
    }
    fn set_position_demand_value(&mut self, value: i32) {
        self.put_i32(0x6062, value);
    }
    fn set_position_actual_internal_value(&mut self, value: i32) {
        self.put_i32(0x6063, value);
    }
    fn set_position_actual_value(&mut self, value: i32) {
        self.put_i32(0x6064, value);
    }
    fn position_window(&self) -> u32 {
        self.u32(0x6067, 0)
    }
    fn position_window_time(&self) -> u16 {
        self.u16(0x6068)
    }
    fn target_position(&self) -> i32 {
        self.u32(0x607A, 0).cast_signed()
    }
    fn min_position_limit(&self) -> i32 {
        self.u32(0x607D, 1).cast_signed()
    }
    fn max_position_limit(&self) -> i32 {
        self.u32(0x607D, 2).cast_signed()
    }
    fn profile_velocity(&self) -> u32 {
        self.u32(0x6081, 0)
    }
    fn profile_acceleration(&self) -> u32 {
        self.u32(0x6083, 0)
    }
    fn profile_deceleration(&self) -> u32 {
        self.u32(0x6084, 0)
    }
    fn quick_stop_deceleration(&self) -> u32 {
        self.u32(0x6085, 0)
    }
    fn vl_target_velocity(&self) -> i16 {
        self.u16(0x6042).cast_signed()
    }
    fn set_velocity_demand_value(&mut self, value: i32) {
        self.put_i32(0x606B, value);
    }
    fn set_velocity_actual_value(&mut self, value: i32) {
        self.put_i32(0x606C, value);
    }
    fn target_velocity(&self) -> i32 {
        self.u32(0x60FF, 0).cast_signed()
    }
    fn supported_drive_modes(&self) -> u32 {
        self.u32(0x6502, 0)
    }
}
