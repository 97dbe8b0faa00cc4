//! An axis as a file in TOML: what `sim serve --plant` reads. The folder `sim/plants` has some that are ready.

use std::fs;
use std::path::Path;

use canopen::Duration;
use serde::Deserialize;

use super::contact::Switch;
use super::track::{Index, Track};
use crate::system_error::plain;

/// An axis, and where the motor stands on it at its first power-on. The default has nothing along it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Axis {
    /// What is mounted.
    pub track: Track,
    /// Where the motor stands, in steps.
    pub start: i64,
    /// Decides how contacts bounce.
    pub seed: u64,
    /// The drive counts what the motor does, not its pulses.
    pub encoder: bool,
}

/// The file.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    #[serde(default)]
    start: i32,
    #[serde(default)]
    seed: u32,
    #[serde(default)]
    encoder: bool,
    turn: Option<u32>,
    stops: Option<Stops>,
    negative_limit: Option<Limit>,
    positive_limit: Option<Limit>,
    home: Option<Home>,
    index: Option<IndexPulses>,
    probe_1: Option<Home>,
    probe_2: Option<Home>,
}

/// `[stops]`: the axis cannot leave this range.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Stops {
    low: i32,
    high: i32,
}

/// `[negative_limit]`, `[positive_limit]`: active at this position and beyond.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Limit {
    at: i32,
    #[serde(default)]
    hysteresis: u16,
    #[serde(default)]
    bounce_us: u32,
    #[serde(default)]
    normally_closed: bool,
}

/// `[home]`, `[probe_1]`, `[probe_2]`: active in a range; up to an end of the axis if one of its ends is left out.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Home {
    from: Option<i32>,
    to: Option<i32>,
    #[serde(default)]
    hysteresis: u16,
    #[serde(default)]
    bounce_us: u32,
    #[serde(default)]
    normally_closed: bool,
}

/// `[index]`: pulses at `first` and every `distance` steps from there.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct IndexPulses {
    first: i32,
    distance: u32,
}

impl Axis {
    /// Reads an axis.
    ///
    /// # Errors
    /// What is wrong with the file, in one line with its name and the line in it.
    pub fn read(path: &Path) -> Result<Self, String> {
        let text = fs::read_to_string(path)
            .map_err(|error| format!("cannot read {}: {}", path.display(), plain(error)))?;
        Self::from_toml(&text).map_err(|(line, what)| match line {
            Some(line) => format!("{}:{line}: {what}", path.display()),
            None => format!("{}: {what}", path.display()),
        })
    }

    /// Reads the text of a file.
    ///
    /// # Errors
    /// The line, if it is known, and what is wrong.
    pub fn from_toml(text: &str) -> Result<Self, (Option<usize>, String)> {
        let file: File = toml::from_str(text).map_err(|error| {
            let line = error
                .span()
                .and_then(|span| text.get(..span.start))
                .map(|before| before.matches('\n').count() + 1);
            (line, error.message().replace('\n', " "))
        })?;
        file.check().map_err(|what| (None, what))?;
        Ok(Self {
            start: file.start.into(),
            seed: file.seed.into(),
            encoder: file.encoder,
            track: file.track(),
        })
    }
}

impl File {
    /// What the types do not say.
    fn check(&self) -> Result<(), String> {
        if let Some(stops) = &self.stops
            && !(stops.low..=stops.high).contains(&self.start)
        {
            return Err(format!(
                "start = {} is not between the stops {} and {}",
                self.start, stops.low, stops.high
            ));
        }
        let ranges = [
            ("home", &self.home),
            ("probe_1", &self.probe_1),
            ("probe_2", &self.probe_2),
        ];
        for (name, range) in ranges {
            if let Some(range) = range
                && let (Some(from), Some(to)) = (range.from, range.to)
                && from > to
            {
                return Err(format!("{name}: from = {from} is above to = {to}"));
            }
        }
        if self.turn == Some(0) {
            return Err("turn = 0".to_owned());
        }
        if self.index.as_ref().is_some_and(|index| index.distance == 0) {
            return Err("index: distance = 0".to_owned());
        }
        Ok(())
    }

    fn track(self) -> Track {
        let fit = |switch: Switch, hysteresis: u16, bounce_us: u32, normally_closed| Switch {
            hysteresis: hysteresis.into(),
            bounce: Duration::from_ticks(bounce_us.into()),
            normally_closed,
            ..switch
        };
        let limit = |limit: Limit, switch| {
            fit(
                switch,
                limit.hysteresis,
                limit.bounce_us,
                limit.normally_closed,
            )
        };
        let within = |home: Home| {
            let from = home.from.map_or(i64::MIN / 2, i64::from);
            let to = home.to.map_or(i64::MAX / 2, i64::from);
            fit(
                Switch::within(from..=to),
                home.hysteresis,
                home.bounce_us,
                home.normally_closed,
            )
        };
        Track {
            negative_limit: self.negative_limit.map(|switch| {
                let at = Switch::up_to(switch.at.into());
                limit(switch, at)
            }),
            positive_limit: self.positive_limit.map(|switch| {
                let at = Switch::from(switch.at.into());
                limit(switch, at)
            }),
            home: self.home.map(within),
            probes: [self.probe_1.map(within), self.probe_2.map(within)],
            index: self.index.map(|index| Index {
                first: index.first.into(),
                distance: index.distance,
            }),
            turn: self.turn,
            stops: self.stops.map(|stops| stops.low.into()..=stops.high.into()),
        }
    }
}

#[cfg(test)]
mod tests;
