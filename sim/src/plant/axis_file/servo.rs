//! `[servo]`: a motor that is moved by its current, and what tells where its magnet is.

use serde::Deserialize;
use servo::feedback::absolute::NO_ERROR;
use toml::Spanned;

use crate::plant::servo::{AXES, Magnet, ServoAxisData, eccentricity_table};

/// The keys.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Servo {
    axis: Spanned<String>,
    feedback: Option<Feedback>,
    bits: Option<Spanned<u8>>,
    eccentricity_mrad: Option<Spanned<u16>>,
    table: Option<Spanned<bool>>,
}

/// What tells where the magnet is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
enum Feedback {
    Incremental,
    Hall,
    Absolute,
}

/// How far a magnet can be off its centre, in mrad: beyond, its angle would come back here and there.
const MOST_ECCENTRIC: u16 = 500;

impl Servo {
    /// The ready axis with this feedback.
    ///
    /// # Errors
    /// Where in the text, and what is wrong.
    pub(super) fn data(&self) -> Result<ServoAxisData, (usize, String)> {
        let mut data = ServoAxisData::named(self.axis.get_ref()).ok_or_else(|| {
            let names = AXES.map(|axis| format!("`{}`", axis.name)).join(", ");
            let what = format!("`{}` is no ready axis: {names}", self.axis.get_ref());
            (self.axis.span().start, what)
        })?;
        match self.feedback {
            None => {}
            Some(Feedback::Incremental) => data.magnet = Magnet::Searched,
            Some(Feedback::Hall) => data.magnet = Magnet::Hall,
            Some(Feedback::Absolute) => data.magnet = Magnet::Absolute(&NO_ERROR),
        }
        if let Magnet::Absolute(table) = &mut data.magnet {
            let sensors = &mut data.plant.sensors;
            if let Some(bits) = &self.bits {
                if !(12..=20).contains(bits.get_ref()) {
                    let what = format!("bits = {} is not 12 to 20", bits.get_ref());
                    return Err((bits.span().start, what));
                }
                sensors.bits = *bits.get_ref();
            }
            if let Some(peak) = &self.eccentricity_mrad {
                if *peak.get_ref() > MOST_ECCENTRIC {
                    let what = format!("eccentricity_mrad: at most {MOST_ECCENTRIC}");
                    return Err((peak.span().start, what));
                }
                sensors.eccentricity = f64::from(*peak.get_ref()) * 1e-3;
            }
            if self.table.as_ref().is_some_and(|table| *table.get_ref()) {
                *table = eccentricity_table(sensors.eccentricity);
            }
            return Ok(data);
        }
        let of_absolute = [
            self.bits.as_ref().map(|key| ("bits", key.span().start)),
            (self.eccentricity_mrad.as_ref()).map(|key| ("eccentricity_mrad", key.span().start)),
            self.table.as_ref().map(|key| ("table", key.span().start)),
        ];
        match of_absolute.into_iter().flatten().next() {
            Some((key, at)) => Err((at, format!("{key} needs feedback = \"absolute\""))),
            None => Ok(data),
        }
    }
}
