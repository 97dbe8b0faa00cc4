//! A data sheet as it is meant: the device, and its object dictionary.
//!
//! EDS, DCF and XDD files are read into this model. Two models are equal when they mean the same: where something stands in its
//! file, and how it is spelled there, makes no difference.

mod device;
mod entry;
mod module;
mod places;
mod remarks;
mod value;

use std::ops::RangeInclusive;

pub use device::{Commissioning, DeviceInfo, FileInfo, FileKind};
pub use entry::{Access, Entry, Note, StorageGroup};
pub use module::{DynamicChannel, Extension, Module};
pub use places::{Field, KeyPlaces, Places};
pub use remarks::{Remarks, Tools};
pub use value::{DefaultValue, Limit};

/// A device: who it is, and its object dictionary.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Model {
    /// The file it was read from, as its reader named it.
    pub file: String,
    /// What kind of file that was.
    pub kind: FileKind,
    /// The section FileInfo.
    pub file_info: FileInfo,
    /// The section DeviceInfo.
    pub device: DeviceInfo,
    /// The section DeviceComissioning of a DCF: the node that is configured.
    pub commissioning: Option<Commissioning>,
    /// The data types that DummyUsage allows as gaps in a receive PDO, by index.
    pub dummies: Vec<u16>,
    /// The lines of the section Comments.
    pub comments: Vec<String>,
    /// What the file says to tools.
    pub tools: Tools,
    /// Comments above the first section.
    pub remarks: Remarks,
    /// Data types that the file defines, 0001h to 0FFFh, by index.
    pub types: Vec<Object>,
    /// The objects by index, 1000h to FFFFh.
    pub objects: Vec<Object>,
    /// The modules that a modular device knows, by their number.
    pub modules: Vec<Module>,
    /// The modules that are plugged, in their order, by number (DCF, ConnectedModules).
    pub connected: Vec<u8>,
    /// DynamicChannels.
    pub dynamic_channels: Vec<DynamicChannel>,
}

impl Model {
    /// The entry at `index`, `sub`.
    pub fn entry(&self, index: u16, sub: u8) -> Option<&Entry> {
        self.object(index)?.entry(sub)
    }

    /// The object at `index`.
    pub fn object(&self, index: u16) -> Option<&Object> {
        let at = self
            .objects
            .binary_search_by_key(&index, |object| object.index);
        self.objects.get(at.ok()?)
    }

    /// The objects with an index in this range.
    pub fn objects_in(&self, indices: RangeInclusive<u16>) -> &[Object] {
        let start = self
            .objects
            .partition_point(|object| object.index < *indices.start());
        let end = self
            .objects
            .partition_point(|object| object.index <= *indices.end());
        self.objects.get(start..end).unwrap_or_default()
    }

    /// Every entry with its object, by index and sub-index.
    pub fn entries(&self) -> impl Iterator<Item = (&Object, &Entry)> {
        self.objects
            .iter()
            .flat_map(|object| object.entries.iter().map(move |entry| (object, entry)))
    }

    /// The highest number of a receive PDO: those at 1400h to 15FFh, and the gaps between them.
    pub fn rpdo_count(&self) -> usize {
        self.highest_pdo(0x1400)
    }

    /// The highest number of a transmit PDO: those at 1800h to 19FFh, and the gaps between them.
    pub fn tpdo_count(&self) -> usize {
        self.highest_pdo(0x1800)
    }

    fn highest_pdo(&self, first: u16) -> usize {
        let last = self.objects_in(first..=first.saturating_add(0x1FF)).last();
        last.map_or(0, |object| usize::from(object.index - first) + 1)
    }

    /// SDO servers: the records at 1200h to 127Fh, and the default server of a device that does not list it.
    pub fn sdo_server_count(&self) -> usize {
        self.objects_in(0x1200..=0x127F).len().max(1)
    }

    /// Heartbeat consumers: the elements of 1016h.
    pub fn heartbeat_consumer_count(&self) -> usize {
        self.object(0x1016).map_or(0, |object| {
            object.entries.iter().filter(|entry| entry.sub != 0).count()
        })
    }

    /// The most objects that one PDO may map: the elements of the longest mapping record at 1600h to 17FFh and 1A00h to 1BFFh,
    /// at least one.
    pub fn mapped_object_count(&self) -> usize {
        [0x1600..=0x17FF, 0x1A00..=0x1BFF]
            .into_iter()
            .flat_map(|indices| self.objects_in(indices))
            .map(|object| object.entries.iter().filter(|entry| entry.sub != 0).count())
            .max()
            .unwrap_or(1)
    }
}

/// The kinds of object (CiA 301, table 42).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum ObjectType {
    /// A place that is taken, without a value.
    Null,
    /// A value of any length, served by the application piece by piece.
    Domain,
    /// A data type.
    DefType,
    /// A data type made of others.
    DefStruct,
    /// One value.
    #[default]
    Var,
    /// Values of one type.
    Array,
    /// Values of any types.
    Record,
}

impl ObjectType {
    const CODES: [(Self, u8, &'static str); 7] = [
        (Self::Null, 0x0, "NULL"),
        (Self::Domain, 0x2, "DOMAIN"),
        (Self::DefType, 0x5, "DEFTYPE"),
        (Self::DefStruct, 0x6, "DEFSTRUCT"),
        (Self::Var, 0x7, "VAR"),
        (Self::Array, 0x8, "ARRAY"),
        (Self::Record, 0x9, "RECORD"),
    ];

    /// The kind with this object code.
    pub fn from_code(code: i128) -> Option<Self> {
        let kinds = Self::CODES.into_iter();
        let mut found = kinds.filter(|(_, own, _)| i128::from(*own) == code);
        found.next().map(|(kind, ..)| kind)
    }

    /// The kind with this name, in capital or small letters.
    pub(crate) fn from_name(name: &str) -> Option<Self> {
        let mut kinds = Self::CODES.into_iter();
        let found = kinds.find(|(.., own)| own.eq_ignore_ascii_case(name));
        found.map(|(kind, ..)| kind)
    }

    fn row(self) -> (Self, u8, &'static str) {
        let is_own = |row: &(Self, u8, &str)| row.0 == self;
        let found = Self::CODES.into_iter().find(is_own);
        found.unwrap_or((self, 0x7, "VAR"))
    }

    /// Its object code.
    pub fn code(self) -> u8 {
        self.row().1
    }

    /// The name the standard gives it.
    pub fn name(self) -> &'static str {
        self.row().2
    }

    /// Whether its values have sub-indices.
    pub fn has_subs(self) -> bool {
        matches!(self, Self::Array | Self::Record | Self::DefStruct)
    }
}

/// An object.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Object {
    /// Index.
    pub index: u16,
    /// ParameterName.
    pub name: String,
    /// ObjectType.
    pub object_type: ObjectType,
    /// DataType of an object whose sub-indices have their own: of a RECORD the DEFSTRUCT, of an ARRAY its elements' type.
    pub data_type: Option<u16>,
    /// ObjFlags; bit 0: not written when a configuration is downloaded, bit 1: not read when it is scanned.
    pub flags: u32,
    /// By sub-index; one with sub-index 0 for a VAR and a DOMAIN, none for NULL.
    pub entries: Vec<Entry>,
    /// Denotation of an object with sub-indices, in a DCF.
    pub denotation: Option<String>,
    /// Comments of the form `;Name=value` in the section of an object with sub-indices.
    pub notes: Vec<Note>,
    /// The other comments there.
    pub remarks: Remarks,
    /// Where it stands in its file.
    pub places: Places,
}

impl Object {
    /// The entry at `sub`.
    pub fn entry(&self, sub: u8) -> Option<&Entry> {
        let at = self.entries.binary_search_by_key(&sub, |entry| entry.sub);
        self.entries.get(at.ok()?)
    }
}
