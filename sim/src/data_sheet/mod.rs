//! Data sheets at run time: what objects are called and what they hold, for traces and for the tool `axis402`.
//!
//! Without a data sheet of a device, the objects that CiA 301 and CiA 402 define still have their names and types; those of its
//! manufacturer are numbers.

use std::sync::{Arc, LazyLock};

use od_gen::Model;
use od_gen::model::{Entry, Object};

/// The data sheet of a device, or what the standards say of any.
#[derive(Debug)]
pub struct DataSheet {
    model: Model,
}

/// The data sheet of the generic drive.
const AXIS402: (&str, &str) = ("axis402.eds", include_str!("../../../eds/axis402.eds"));

impl DataSheet {
    /// The generic drive's own.
    pub fn axis402() -> Arc<Self> {
        static SHEET: LazyLock<Arc<DataSheet>> =
            LazyLock::new(|| Arc::new(DataSheet::parse(AXIS402.0, AXIS402.1)));
        Arc::clone(&SHEET)
    }

    /// Of any drive: communication objects (1000h to 1FFFh) and those of drives (6000h to 9FFFh), as far as the generic drive
    /// has them.
    pub fn standard() -> Arc<Self> {
        static SHEET: LazyLock<Arc<DataSheet>> = LazyLock::new(|| {
            let mut model = DataSheet::axis402().model.clone();
            let is_standard = |index| matches!(index, 0x1000..=0x1FFF | 0x6000..=0x9FFF);
            model.objects.retain(|object| is_standard(object.index));
            Arc::new(DataSheet { model })
        });
        Arc::clone(&SHEET)
    }

    /// From the text of an EDS, a DCF or an XDD. What is wrong with it is left out: a tool can do with the rest.
    pub fn parse(file: &str, text: &str) -> Self {
        Self {
            model: od_gen::Report::new(file, text).model,
        }
    }

    /// The device and its objects.
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// The object at `index`.
    pub fn object(&self, index: u16) -> Option<&Object> {
        self.model.object(index)
    }

    /// The value at `index`, `sub`.
    pub fn entry(&self, index: u16, sub: u8) -> Option<&Entry> {
        self.model.entry(index, sub)
    }
}
