//! Data sheets at run time: what objects are called and what they hold, for traces and for the tool `axis402`.
//!
//! Without a data sheet of a device, the objects that CiA 301 and CiA 402 define still have their names and types; those of its
//! manufacturer are numbers.

mod object_name;
pub mod value;

use std::sync::{Arc, LazyLock};

use od_gen::Model;
use od_gen::model::{Entry, Object};

pub use object_name::Address;

/// The data sheet of a device, or what the standards say of any.
#[derive(Debug)]
pub struct DataSheet {
    model: Model,
}

impl DataSheet {
    /// That of the generic drive.
    pub fn axis402() -> Arc<Self> {
        static SHEET: LazyLock<Arc<DataSheet>> = LazyLock::new(|| {
            let text = include_str!("../../../eds/axis402.eds");
            Arc::new(DataSheet::parse("axis402.eds", text))
        });
        Arc::clone(&SHEET)
    }

    /// That of the generic drive with a servo, made of `eds/servo.toml` by the build.
    pub fn servo() -> Arc<Self> {
        static SHEET: LazyLock<Arc<DataSheet>> = LazyLock::new(|| {
            let text = include_str!(concat!(env!("OUT_DIR"), "/servo.eds"));
            Arc::new(DataSheet::parse("servo.eds", text))
        });
        Arc::clone(&SHEET)
    }

    /// That of a device with this vendor-ID and product code, if it is one that needs no file.
    pub fn built_in(vendor_id: u32, product_code: u32) -> Option<Arc<Self>> {
        let mut all = [Self::axis402(), Self::servo()].into_iter();
        all.find(|sheet| sheet.is_of(vendor_id, product_code))
    }

    /// Of any drive: communication objects (1000h to 1FFFh) and those of drives (6000h to 9FFFh), as far as the generic drive
    /// has them.
    pub fn standard() -> Arc<Self> {
        static SHEET: LazyLock<Arc<DataSheet>> = LazyLock::new(|| {
            let mut model = DataSheet::axis402().model.clone();
            let is_standard = |index| matches!(index, 0x1000..=0x1FFF | 0x6000..=0x9FFF);
            model.objects.retain(|object| is_standard(object.index));
            model.file = "the standard objects; --eds names a data sheet".to_owned();
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

    /// The file it was read from, for messages.
    pub fn title(&self) -> &str {
        &self.model.file
    }

    /// Whether it is that of a device with this vendor-ID and product code (1018h:1 and 2).
    pub fn is_of(&self, vendor_id: u32, product_code: u32) -> bool {
        let device = &self.model.device;
        (device.vendor_number, device.product_number) == (Some(vendor_id), Some(product_code))
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

impl From<Model> for DataSheet {
    fn from(model: Model) -> Self {
        Self { model }
    }
}
