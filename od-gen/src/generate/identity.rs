//! The identity that a build gives to a device (1018h), whatever the data sheet states: devices of one data sheet with numbers of their own.

use std::str::FromStr;

use crate::model::{DefaultValue, Model};

/// Numbers in the place of those of the data sheet; `None` leaves what stands there.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Identity {
    /// 1018h:1 and VendorNumber.
    pub vendor_id: Option<u32>,
    /// 1018h:2 and ProductNumber.
    pub product_code: Option<u32>,
    /// 1018h:3 and RevisionNumber.
    pub revision_number: Option<u32>,
    /// 1018h:4.
    pub serial_number: Option<u32>,
}

/// The names of its numbers, in the order of the object.
const NAMES: [&str; 4] = [
    "vendor_id",
    "product_code",
    "revision_number",
    "serial_number",
];

impl Identity {
    /// What the data sheet states.
    pub const STATED: Self = Self {
        vendor_id: None,
        product_code: None,
        revision_number: None,
        serial_number: None,
    };

    fn numbers(self) -> [Option<u32>; 4] {
        [
            self.vendor_id,
            self.product_code,
            self.revision_number,
            self.serial_number,
        ]
    }

    /// The same with the numbers of another one where that has some.
    #[must_use]
    pub fn with(self, other: Self) -> Self {
        Self {
            vendor_id: other.vendor_id.or(self.vendor_id),
            product_code: other.product_code.or(self.product_code),
            revision_number: other.revision_number.or(self.revision_number),
            serial_number: other.serial_number.or(self.serial_number),
        }
    }

    /// Sets the numbers in DeviceInfo and 1018h.
    ///
    /// # Errors
    /// Which of them the dictionary has no place for.
    pub fn set(self, model: &mut Model) -> Result<(), String> {
        for ((sub, name), number) in (1..).zip(NAMES).zip(self.numbers()) {
            let Some(number) = number else {
                continue;
            };
            let device = &mut model.device;
            match sub {
                1 => device.vendor_number = Some(number),
                2 => device.product_number = Some(number),
                3 => device.revision_number = Some(number),
                _ => {}
            }
            let mut objects = model.objects.iter_mut();
            let entry = objects
                .find(|object| object.index == 0x1018)
                .and_then(|object| object.entries.iter_mut().find(|entry| entry.sub == sub))
                .ok_or_else(|| format!("{name} has no place: the data sheet has no 1018h:{sub}"))?;
            let value = DefaultValue::number(number.into());
            entry.configured = entry.configured.is_some().then(|| value.clone());
            entry.default = Some(value);
        }
        Ok(())
    }
}

/// `product_code=0x402`.
impl FromStr for Identity {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let usage = || format!("write it as NAME=NUMBER, with one of {}", NAMES.join(", "));
        let (name, number) = text.split_once('=').ok_or_else(usage)?;
        let number = number.trim();
        let digits = number.strip_prefix("0x").or(number.strip_prefix("0X"));
        let parsed = match digits {
            Some(digits) => u32::from_str_radix(digits, 16),
            None => number.parse(),
        };
        let number = parsed.map_err(|_| format!("`{number}` is not a number of 32 bits"))?;
        let mut identity = Self::STATED;
        let place = match name.trim() {
            "vendor_id" => &mut identity.vendor_id,
            "product_code" => &mut identity.product_code,
            "revision_number" => &mut identity.revision_number,
            "serial_number" => &mut identity.serial_number,
            _ => return Err(usage()),
        };
        *place = Some(number);
        Ok(identity)
    }
}
