//! A data sheet that has passed every check.

use crate::data_type::DataType;

/// A device: who it is, and its object dictionary.
#[derive(Clone, Debug, PartialEq)]
pub struct Model {
    /// The file it was read from, as its reader named it.
    pub file: String,
    /// The section DeviceInfo.
    pub device: DeviceInfo,
    /// The objects by index.
    pub objects: Vec<Object>,
}

impl Model {
    /// The entry at `index`, `sub`.
    pub fn entry(&self, index: u16, sub: u8) -> Option<&Entry> {
        self.object(index)?
            .entries
            .iter()
            .find(|entry| entry.sub == sub)
    }

    /// The object at `index`.
    pub fn object(&self, index: u16) -> Option<&Object> {
        self.objects.iter().find(|object| object.index == index)
    }

    /// Receive PDOs: the communication records at 1400h to 15FFh.
    pub fn rpdo_count(&self) -> usize {
        self.count(0x1400..=0x15FF)
    }

    /// Transmit PDOs: the communication records at 1800h to 19FFh.
    pub fn tpdo_count(&self) -> usize {
        self.count(0x1800..=0x19FF)
    }

    /// SDO servers: the records at 1200h to 127Fh, and the default server of a device that does not list it.
    pub fn sdo_server_count(&self) -> usize {
        self.count(0x1200..=0x127F).max(1)
    }

    /// Heartbeat consumers: the elements of 1016h.
    pub fn heartbeat_consumer_count(&self) -> usize {
        self.object(0x1016).map_or(0, |object| {
            object.entries.iter().filter(|entry| entry.sub != 0).count()
        })
    }

    fn count(&self, indices: std::ops::RangeInclusive<u16>) -> usize {
        self.objects
            .iter()
            .filter(|object| indices.contains(&object.index))
            .count()
    }
}

/// What a data sheet says about the device as a whole (CiA 306, DeviceInfo).
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct DeviceInfo {
    /// Who makes it.
    pub vendor_name: String,
    /// What it is called.
    pub product_name: String,
    /// Bit rates in kbit/s.
    pub bit_rates: Vec<u16>,
    /// Whether LSS can configure it.
    pub lss: bool,
}

/// The kinds of object (CiA 301, table 42).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ObjectType {
    /// One value.
    Var,
    /// Values of one type.
    Array,
    /// Values of any types.
    Record,
}

/// An object.
#[derive(Clone, Debug, PartialEq)]
pub struct Object {
    /// Index, 1000h to FFFFh.
    pub index: u16,
    /// ParameterName.
    pub name: String,
    /// Kind.
    pub object_type: ObjectType,
    /// By sub-index; one with sub-index 0 for a VAR.
    pub entries: Vec<Entry>,
    /// Line of its section.
    pub line: usize,
}

/// One value.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// Sub-index.
    pub sub: u8,
    /// ParameterName.
    pub name: String,
    /// Data type.
    pub data_type: DataType,
    /// AccessType.
    pub access: Access,
    /// PDOMapping; [`Entry::is_rpdo_mappable`] and [`Entry::is_tpdo_mappable`] say what it means.
    pub pdo_mapping: bool,
    /// LowLimit, where it is narrower than the type.
    pub low_limit: Option<i64>,
    /// HighLimit, where it is narrower than the type.
    pub high_limit: Option<i64>,
    /// DefaultValue.
    pub default: DefaultValue,
    /// Length in bytes; of a string that can be written, the most it can hold.
    pub size: u16,
    /// Line of its section.
    pub line: usize,
}

impl Entry {
    /// Whether a receive PDO may write it.
    pub fn is_rpdo_mappable(&self) -> bool {
        self.pdo_mapping
            && matches!(
                self.access,
                Access::WriteOnly | Access::ReadWrite | Access::ReadWriteOutput
            )
    }

    /// Whether a transmit PDO may carry it.
    pub fn is_tpdo_mappable(&self) -> bool {
        let readable = !matches!(self.access, Access::WriteOnly | Access::ReadWriteOutput);
        self.pdo_mapping && readable
    }

    /// The default as a number; `None` for strings.
    pub fn default_number(&self) -> Option<i128> {
        match self.default {
            DefaultValue::Number { value, .. } => Some(value),
            DefaultValue::Text(_) => None,
        }
    }
}

/// Who may do what over the bus (CiA 306, AccessType).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Access {
    /// `ro`: the device changes it.
    ReadOnly,
    /// `wo`.
    WriteOnly,
    /// `rw`.
    ReadWrite,
    /// `rwr`: as `rw`, an input of the process; PDOs only transmit it.
    ReadWriteInput,
    /// `rww`: as `rw`, an output of the process; PDOs only receive it.
    ReadWriteOutput,
    /// `const`.
    Constant,
}

impl Access {
    /// The access with this name.
    pub fn from_name(name: &str) -> Option<Self> {
        Some(match name.to_ascii_lowercase().as_str() {
            "ro" => Self::ReadOnly,
            "wo" => Self::WriteOnly,
            "rw" => Self::ReadWrite,
            "rwr" => Self::ReadWriteInput,
            "rww" => Self::ReadWriteOutput,
            "const" => Self::Constant,
            _ => return None,
        })
    }

    /// Whether it can be written over the bus.
    pub fn is_writable(self) -> bool {
        !matches!(self, Self::ReadOnly | Self::Constant)
    }

    /// Whether it can be read over the bus.
    pub fn is_readable(self) -> bool {
        self != Self::WriteOnly
    }
}

/// A value at power-on.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum DefaultValue {
    /// Of a number.
    Number {
        /// The number in the data sheet.
        value: i128,
        /// Whether the node-ID is added to it.
        adds_node_id: bool,
    },
    /// Of a string.
    Text(Vec<u8>),
}
