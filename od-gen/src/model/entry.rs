//! One value of the dictionary.

use super::places::Places;
use super::remarks::Remarks;
use super::value::{DefaultValue, Limit};
use crate::data_type::DataType;

/// One value.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// Sub-index.
    pub sub: u8,
    /// ParameterName.
    pub name: String,
    /// DataType.
    pub data_type: DataType,
    /// AccessType.
    pub access: Access,
    /// PDOMapping; [`Entry::is_rpdo_mappable`] and [`Entry::is_tpdo_mappable`] say what it means.
    pub pdo_mapping: bool,
    /// LowLimit, as it is stated; [`Entry::integer_limits`] leaves out what the type asks for anyway.
    pub low_limit: Option<Limit>,
    /// HighLimit, as it is stated.
    pub high_limit: Option<Limit>,
    /// DefaultValue, where the file states one; [`Entry::initial`] stands in for it. Never an empty text.
    pub default: Option<DefaultValue>,
    /// Length in bytes; of a string that can be written, the most it can hold. Of a DOMAIN the most it has, 0 for no bound.
    pub size: u16,
    /// ObjFlags; bit 0: not written when a configuration is downloaded, bit 1: not read when it is scanned.
    pub flags: u32,
    /// ParameterValue of a DCF: what this device is configured to.
    pub configured: Option<DefaultValue>,
    /// Denotation of a DCF: what it is called in this device.
    pub denotation: Option<String>,
    /// UploadFile of a DCF: where what is read goes.
    pub upload_file: Option<String>,
    /// DownloadFile of a DCF: where what is written comes from.
    pub download_file: Option<String>,
    /// Whether the application has it and the dictionary does not: `;Memory=application`. DOMAINs and long strings are with the
    /// application in any case.
    pub is_with_application: bool,
    /// What stores it at 1010h; `None` for what is lost at power-off.
    pub storage: Option<StorageGroup>,
    /// Comments of the form `;Name=value` in its section, such as `;Unit=mm/s`.
    pub notes: Vec<Note>,
    /// The other comments there.
    pub remarks: Remarks,
    /// Where it stands in its file.
    pub places: Places,
}

impl Entry {
    /// A value of this type that can be read and written, without a default and without limits.
    pub fn new(sub: u8, name: impl Into<String>, data_type: DataType) -> Self {
        Self {
            sub,
            name: name.into(),
            data_type,
            access: Access::ReadWrite,
            pdo_mapping: false,
            low_limit: None,
            high_limit: None,
            default: None,
            size: data_type.size().unwrap_or_default(),
            flags: 0,
            configured: None,
            denotation: None,
            upload_file: None,
            download_file: None,
            is_with_application: false,
            storage: None,
            notes: Vec::new(),
            remarks: Remarks::default(),
            places: Places::default(),
        }
    }

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

    /// What a generated dictionary starts with: the default, or 0 or empty where the file states none.
    pub fn initial(&self) -> DefaultValue {
        self.default.clone().unwrap_or(match self.data_type {
            DataType::Real32 | DataType::Real64 => DefaultValue::Real(0.0),
            _ if self.data_type.size().is_some() => DefaultValue::number(0),
            _ => DefaultValue::Text(Vec::new()),
        })
    }

    /// The default as an integer; `None` for strings and REAL numbers, and where the file states none.
    pub fn default_number(&self) -> Option<i128> {
        match self.default {
            Some(DefaultValue::Number { value, .. }) => Some(value),
            _ => None,
        }
    }

    /// Whether the node-ID is added to the default.
    pub fn adds_node_id(&self) -> bool {
        let default = self.default.as_ref();
        default.is_some_and(DefaultValue::adds_node_id)
    }

    /// The limits of an integer where they are narrower than its type's own.
    pub fn integer_limits(&self) -> (Option<i128>, Option<i128>) {
        let Some((low, high)) = self.data_type.range() else {
            return (None, None);
        };
        let narrower =
            |limit: Option<Limit>, own: i128| limit?.integer().filter(|value| *value != own);
        (
            narrower(self.low_limit, low),
            narrower(self.high_limit, high),
        )
    }

    /// The note of this name: `note("Unit")` for the comment `;Unit=mm/s`.
    pub fn note(&self, name: &str) -> Option<&str> {
        find_note(&self.notes, name)
    }

    /// Its unit, where the file says it.
    pub fn unit(&self) -> Option<&str> {
        self.note("Unit")
    }
}

/// The note of this name.
pub(crate) fn find_note<'a>(notes: &'a [Note], name: &str) -> Option<&'a str> {
    let found = notes
        .iter()
        .find(|note| note.name.eq_ignore_ascii_case(name));
    found.map(|note| note.value.as_str())
}

/// A comment of the form `;Name=value`: what CiA 306 has no key for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Note {
    /// Before the `=`.
    pub name: String,
    /// After the `=`.
    pub value: String,
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
    const NAMES: [(Self, &'static str); 6] = [
        (Self::ReadOnly, "ro"),
        (Self::WriteOnly, "wo"),
        (Self::ReadWrite, "rw"),
        (Self::ReadWriteInput, "rwr"),
        (Self::ReadWriteOutput, "rww"),
        (Self::Constant, "const"),
    ];

    /// The access with this name.
    pub fn from_name(name: &str) -> Option<Self> {
        let found = Self::NAMES
            .into_iter()
            .find(|(_, own)| own.eq_ignore_ascii_case(name));
        found.map(|(access, _)| access)
    }

    /// What was plainly meant by a text that is no name: `r/o`, `RW.`, `read-write`.
    pub(crate) fn meant(text: &str) -> Option<Self> {
        let letters = text.chars().filter(char::is_ascii_alphanumeric);
        let letters: String = letters.collect::<String>().to_ascii_lowercase();
        let spelled = match letters.as_str() {
            "read" | "readonly" => "ro",
            "write" | "writeonly" => "wo",
            "readwrite" | "wr" => "rw",
            "constant" => "const",
            other => other,
        };
        Self::from_name(spelled)
    }

    /// The name that CiA 306 gives it.
    pub fn name(self) -> &'static str {
        let found = Self::NAMES.into_iter().find(|(access, _)| *access == self);
        found.map_or("", |(_, name)| name)
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

/// Which sub-index of 1010h and 1011h stores and restores a value (CiA 301, 7.5.2.13 and 7.5.2.14).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum StorageGroup {
    /// Sub-index 2.
    Communication,
    /// Sub-index 3.
    Application,
    /// Sub-index 4.
    Manufacturer,
}

impl StorageGroup {
    const NAMES: [(Self, &'static str); 3] = [
        (Self::Communication, "communication"),
        (Self::Application, "application"),
        (Self::Manufacturer, "manufacturer"),
    ];

    /// The group with this name.
    pub fn from_name(name: &str) -> Option<Self> {
        let found = Self::NAMES
            .into_iter()
            .find(|(_, own)| own.eq_ignore_ascii_case(name));
        found.map(|(group, _)| group)
    }

    /// Its name in the comment `;Storage=`.
    pub fn name(self) -> &'static str {
        let found = Self::NAMES.into_iter().find(|(group, _)| *group == self);
        found.map_or("", |(_, name)| name)
    }

    /// The group of a value for which the file says nothing: what can be read and written and is no process data, by its
    /// range of indices. The error list and the objects that store and restore are not stored themselves.
    pub fn default_of(index: u16, access: Access) -> Option<Self> {
        if access != Access::ReadWrite {
            return None;
        }
        match index {
            0x1003 | 0x1010 | 0x1011 => None,
            0x1000..=0x1FFF => Some(Self::Communication),
            0x2000..=0x5FFF => Some(Self::Manufacturer),
            0x6000..=0x9FFF => Some(Self::Application),
            _ => None,
        }
    }
}
