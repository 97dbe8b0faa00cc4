//! An axis as a file in TOML: what `sim serve --plant` reads. `docs/plant.md` tells of each key, and the folder `sim/plants` has some
//! axes that are ready.

mod sections;
mod servo;

use std::path::Path;

use super::motor::{MotorData, SupplyData};
use super::servo::ServoAxisData;
use super::track::Track;
use crate::settings::Settings;
use master::data_sheet::{Address, DataSheet};
use master::system_error::plain;
use sections::{File, Mistake};

/// An axis, and where the motor stands on it at its first power-on. The default has nothing along it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Axis {
    /// What is mounted.
    pub track: Track,
    /// Where the motor stands, in steps.
    pub start: i64,
    /// Decides how contacts bounce.
    pub seed: u64,
    /// The drive counts what the motor does, not its pulses.
    pub encoder: bool,
    /// What moves it. Without one each pulse is a step, whatever the current and the load.
    pub motor: Option<MotorData>,
    /// What moves it by its current. Then `motor` and `supply` are of no account.
    pub servo: Option<ServoAxisData>,
    /// What feeds it. Without one nothing ever happens to the supply.
    pub supply: Option<SupplyData>,
    /// What a drive on this axis is set to by the factory.
    pub settings: Settings,
}

impl Axis {
    /// A ready axis with a servo, and a drive that is set to it.
    pub fn servo(data: &ServoAxisData) -> Self {
        Self::bare_servo(data).with_drive_set_up()
    }

    /// The same for a drive whose data sheet has the limits and units of its motor: a product.
    pub fn bare_servo(data: &ServoAxisData) -> Self {
        Self {
            servo: Some(*data),
            encoder: true,
            ..Self::default()
        }
    }

    /// With the generic drive set to the motor of a servo. What the axis has set stays.
    ///
    /// # Panics
    /// Never: its settings are objects of the drive.
    #[must_use]
    fn with_drive_set_up(mut self) -> Self {
        let Some(data) = &self.servo else {
            return self;
        };
        let sheet = DataSheet::servo();
        let motor = data.motor();
        let counts = i64::from(motor.counts);
        let rated = f64::from(motor.rated_current) * 1e3;
        let peak = f64::from(motor.peak_current / motor.rated_current) * 1e3;
        for (object, number) in [
            ("607Fh", counts * i64::from(data.speed) / 60),
            ("6080h", data.speed.into()),
            ("6072h", peak as i64),
            ("6073h", peak as i64),
            ("6075h", rated.round() as i64),
            ("6076h", data.rated_torque().into()),
            ("6085h", counts * 200),
            ("608Fh:1", counts),
            ("6092h:1", counts),
            ("60E0h", peak as i64),
            ("60E1h", peak as i64),
        ] {
            let address = sheet.find(object).expect("an object of the drive");
            let is_set = |(set, _): &(Address, _)| *set == address;
            if !self.settings.values().iter().any(is_set) {
                let is_taken = self.settings.set(&sheet, object, number);
                is_taken.expect("a setting of the drive");
            }
        }
        self
    }

    /// Reads an axis. With a servo, the drive is set to its motor.
    ///
    /// # Errors
    /// What is wrong with the file, in one line with its name and the line in it.
    pub fn read(path: &Path) -> Result<Self, String> {
        Self::read_bare(path).map(Self::with_drive_set_up)
    }

    /// The same for a product: see [`Axis::bare_servo`].
    ///
    /// # Errors
    /// As [`Axis::read`].
    pub fn read_bare(path: &Path) -> Result<Self, String> {
        let text = od_gen::files::read_text(path)
            .map_err(|error| format!("cannot read {}: {}", path.display(), plain(error)))?;
        Self::bare_from_toml(&text).map_err(|(line, what)| match line {
            Some(line) => format!("{}:{line}: {what}", path.display()),
            None => format!("{}: {what}", path.display()),
        })
    }

    /// Reads the text of a file.
    ///
    /// # Errors
    /// The line, if it is known, and what is wrong.
    pub fn from_toml(text: &str) -> Result<Self, (Option<usize>, String)> {
        Self::bare_from_toml(text).map(Self::with_drive_set_up)
    }

    fn bare_from_toml(text: &str) -> Result<Self, (Option<usize>, String)> {
        let line = |offset: usize| {
            text.get(..offset)
                .map(|before| before.matches('\n').count() + 1)
        };
        let file: File = toml::from_str(text).map_err(|error| {
            let line = error.span().and_then(|span| line(span.start));
            (line, error.message().replace('\n', " "))
        })?;
        file.into_axis()
            .map_err(|Mistake { offset, what }| (offset.and_then(line), what))
    }
}

#[cfg(test)]
mod tests;
