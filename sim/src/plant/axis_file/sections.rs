//! The sections of the file. Keys that are not known are refused.

use std::collections::BTreeMap;
use std::num::NonZeroU32;

use canopen::Duration;
use serde::Deserialize;
use toml::Spanned;

use super::Axis;
use super::servo::Servo;
use crate::plant::contact::Switch;
use crate::plant::motor::{Heat, Load, MotorData, SupplyData};
use crate::plant::servo::ServoAxisData;
use crate::plant::track::{Index, Track};
use crate::settings::Settings;
use master::data_sheet::DataSheet;

/// How far an end stop gives way under 1 N·m if the file does not say so, in steps.
const COMPLIANCE: NonZeroU32 = NonZeroU32::new(8).unwrap();

/// What is wrong, and where in the text.
pub(super) struct Mistake {
    pub(super) offset: Option<usize>,
    pub(super) what: String,
}

/// The file.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct File {
    #[serde(default)]
    start: i32,
    #[serde(default)]
    seed: u32,
    #[serde(default)]
    encoder: bool,
    turn: Option<NonZeroU32>,
    stops: Option<Spanned<Stops>>,
    negative_limit: Option<Limit>,
    positive_limit: Option<Limit>,
    home: Option<Range>,
    index: Option<IndexPulses>,
    probe_1: Option<Range>,
    probe_2: Option<Range>,
    motor: Option<Spanned<MotorData>>,
    load: Option<Spanned<Load>>,
    heat: Option<Spanned<Heat>>,
    supply: Option<Spanned<SupplyData>>,
    servo: Option<Spanned<Servo>>,
    #[serde(default)]
    settings: BTreeMap<Spanned<String>, i64>,
}

/// `[stops]`: the axis cannot leave this range.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Stops {
    low: i32,
    high: i32,
    /// How far they give way under 1 N·m, in steps.
    compliance: Option<NonZeroU32>,
}

/// The keys of all switches.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Contact {
    at: Option<i32>,
    from: Option<i32>,
    to: Option<i32>,
    #[serde(default)]
    hysteresis: u16,
    #[serde(default)]
    bounce_us: u32,
    #[serde(default)]
    normally_closed: bool,
}

/// `[negative_limit]`, `[positive_limit]`: active at this position and beyond.
#[derive(Debug, Deserialize)]
#[serde(try_from = "Contact")]
struct Limit {
    at: i32,
    contact: Contact,
}

/// `[home]`, `[probe_1]`, `[probe_2]`: active in a range; up to an end of the axis if one of its ends is left out.
#[derive(Debug, Deserialize)]
#[serde(try_from = "Contact")]
struct Range(Contact);

/// `[index]`: pulses at `first` and every `distance` steps from there.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct IndexPulses {
    first: i32,
    distance: NonZeroU32,
    width: Option<NonZeroU32>,
}

impl TryFrom<Contact> for Limit {
    type Error = &'static str;

    fn try_from(contact: Contact) -> Result<Self, Self::Error> {
        match contact {
            Contact {
                at: Some(at),
                from: None,
                to: None,
                ..
            } => Ok(Self { at, contact }),
            Contact { at: None, .. } => Err("missing field `at`"),
            _ => Err("a limit switch is `at` a position and beyond, not `from` .. `to`"),
        }
    }
}

impl TryFrom<Contact> for Range {
    type Error = String;

    fn try_from(contact: Contact) -> Result<Self, Self::Error> {
        match contact {
            Contact { at: Some(_), .. } => {
                Err("a switch within a range has `from` and `to`, not `at`".to_owned())
            }
            Contact {
                from: Some(from),
                to: Some(to),
                ..
            } if from > to => Err(format!("from = {from} is above to = {to}")),
            _ => Ok(Self(contact)),
        }
    }
}

impl Contact {
    fn fit(&self, switch: Switch) -> Switch {
        Switch {
            hysteresis: self.hysteresis.into(),
            bounce: Duration::from_ticks(self.bounce_us.into()),
            normally_closed: self.normally_closed,
            ..switch
        }
    }
}

impl Limit {
    /// The switch that `place` makes of its position.
    fn switch(self, place: impl FnOnce(i64) -> Switch) -> Switch {
        self.contact.fit(place(self.at.into()))
    }
}

impl Range {
    fn switch(self) -> Switch {
        let from = self.0.from.map_or(i64::MIN / 2, i64::from);
        let to = self.0.to.map_or(i64::MAX / 2, i64::from);
        self.0.fit(Switch::within(from..=to))
    }
}

impl From<IndexPulses> for Index {
    fn from(index: IndexPulses) -> Self {
        Self {
            width: index.width.map_or(1, NonZeroU32::get),
            ..Self::new(index.first.into(), index.distance.get())
        }
    }
}

fn mistake<T>(section: &Spanned<T>, what: impl Into<String>) -> Mistake {
    Mistake {
        offset: Some(section.span().start),
        what: what.into(),
    }
}

impl File {
    /// The axis, if the sections fit together.
    pub(super) fn into_axis(self) -> Result<Axis, Mistake> {
        if let Some(section) = &self.stops {
            let Stops { low, high, .. } = section.get_ref();
            if !(*low..=*high).contains(&self.start) {
                let start = self.start;
                let what = format!("start = {start} is not between the stops {low} and {high}");
                return Err(mistake(section, what));
            }
        }
        Ok(Axis {
            servo: self.servo()?,
            start: self.start.into(),
            seed: self.seed.into(),
            encoder: self.encoder || self.servo.is_some(),
            motor: self.motor()?,
            supply: self.supply.as_ref().map(|supply| supply.get_ref().clone()),
            settings: self.settings()?,
            track: self.track(),
        })
    }

    /// The motor that is moved by its current, with the machine behind it.
    fn servo(&self) -> Result<Option<ServoAxisData>, Mistake> {
        let Some(section) = &self.servo else {
            return Ok(None);
        };
        let not_with = |name| format!("[{name}] does not go with a [servo]");
        let others = [
            self.motor
                .as_ref()
                .map(|other| mistake(other, not_with("motor"))),
            self.load
                .as_ref()
                .map(|other| mistake(other, not_with("load"))),
            self.heat
                .as_ref()
                .map(|other| mistake(other, not_with("heat"))),
            self.supply
                .as_ref()
                .map(|other| mistake(other, not_with("supply"))),
            self.stops
                .as_ref()
                .map(|other| mistake(other, not_with("stops"))),
        ];
        if let Some(mistake) = others.into_iter().flatten().next() {
            return Err(mistake);
        }
        let data = section.get_ref().data().map_err(|(offset, what)| Mistake {
            offset: Some(offset),
            what,
        })?;
        Ok(Some(data.at_work()))
    }

    /// The motor with everything that bears on it.
    fn motor(&self) -> Result<Option<MotorData>, Mistake> {
        let Some(section) = &self.motor else {
            let needed = |name| format!("{name} needs a [motor]");
            return match (&self.load, &self.heat, &self.stops) {
                (Some(load), ..) => Err(mistake(load, needed("[load]"))),
                (_, Some(heat), _) => Err(mistake(heat, needed("[heat]"))),
                (.., Some(stops)) if stops.get_ref().compliance.is_some() => {
                    Err(mistake(stops, needed("compliance")))
                }
                _ => Ok(None),
            };
        };
        let compliance = self
            .stops
            .as_ref()
            .and_then(|stops| stops.get_ref().compliance);
        let motor = MotorData {
            load: Load {
                compliance: compliance.unwrap_or(COMPLIANCE).get(),
                ..get(self.load.as_ref())
            },
            heat: get(self.heat.as_ref()),
            ..section.get_ref().clone()
        };
        motor.check().map_err(|what| mistake(section, what))?;
        if motor.encoder_counts.is_some() && !self.encoder {
            let what = "encoder_counts needs encoder = true at the top of the file";
            return Err(mistake(section, what));
        }
        Ok(Some(motor))
    }

    /// `[settings]`, as the generic drive has them, or that with a servo.
    fn settings(&self) -> Result<Settings, Mistake> {
        let sheet = match self.servo {
            Some(_) => DataSheet::servo(),
            None => DataSheet::axis402(),
        };
        let mut settings = Settings::default();
        for (name, number) in &self.settings {
            settings
                .set(&sheet, name.get_ref(), *number)
                .map_err(|what| mistake(name, what))?;
        }
        Ok(settings)
    }

    fn track(self) -> Track {
        Track {
            negative_limit: self.negative_limit.map(|limit| limit.switch(Switch::up_to)),
            positive_limit: self.positive_limit.map(|limit| limit.switch(Switch::from)),
            home: self.home.map(Range::switch),
            probes: [self.probe_1, self.probe_2].map(|probe| probe.map(Range::switch)),
            index: self.index.map(Index::from),
            turn: self.turn.map(NonZeroU32::get),
            stops: self.stops.map(|stops| {
                let Stops { low, high, .. } = stops.into_inner();
                low.into()..=high.into()
            }),
        }
    }
}

/// A section, or what holds without it.
fn get<T: Clone + Default>(section: Option<&Spanned<T>>) -> T {
    section.map(Spanned::get_ref).cloned().unwrap_or_default()
}
