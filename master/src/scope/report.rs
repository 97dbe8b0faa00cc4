//! A recording for people, for programs, as a table and as a picture.

use std::path::Path;

use serde::Serialize;

use super::{Arguments, Recording};
use crate::axis402::{Console, Problem};
use crate::chart::{self, BLUE, Chart, GREEN, MAGENTA, RED, RGBColor};
use crate::system_error::plain;

/// Colours of the channels, one after the other.
const COLOURS: [RGBColor; 4] = [BLUE, RED, GREEN, MAGENTA];

/// What `--json` prints.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Report {
    node: u8,
    /// The period of the control tick.
    tick_ns: u32,
    divider: u16,
    /// From sample to sample.
    period_s: f64,
    samples: usize,
    /// The sample that is the first behind the trigger.
    trigger_index: usize,
    /// The drive's clock at the trigger.
    trigger_time_us: u64,
    /// When each sample was taken, from the trigger.
    time_s: Vec<f64>,
    channels: Vec<Curve>,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
struct Curve {
    object: String,
    name: String,
    values: Vec<i64>,
}

impl Report {
    /// Of a recording of this node.
    pub fn new(node: u8, recording: &Recording) -> Self {
        let channels = recording.channels.iter().map(|channel| Curve {
            object: channel.address.to_string(),
            name: channel.title.clone(),
            values: channel.values.clone(),
        });
        Self {
            node,
            tick_ns: recording.tick_ns,
            divider: recording.divider,
            period_s: recording.period(),
            samples: recording.count(),
            trigger_index: recording.before,
            trigger_time_us: recording.triggered_us,
            time_s: (0..recording.count()).map(|n| recording.time(n)).collect(),
            channels: channels.collect(),
        }
    }

    /// Writes the files that are asked for, and tells the rest.
    pub(super) fn give(
        &self,
        arguments: &Arguments,
        console: &mut Console<'_>,
    ) -> Result<(), Problem> {
        if let Some(file) = &arguments.csv {
            od_gen::files::write(file, self.table().as_bytes())
                .map_err(|error| unwritable(file, &plain(error)))?;
        }
        if let Some(file) = &arguments.plot {
            self.draw(file).map_err(|why| unwritable(file, &why))?;
        }
        if arguments.json {
            let text = serde_json::to_string(self).map_err(std::io::Error::from)?;
            return console.say(&text);
        }
        self.tell(console)
    }

    fn tell(&self, console: &mut Console<'_>) -> Result<(), Problem> {
        let (first, last) = (self.time_s.first(), self.time_s.last());
        console.say(&format!(
            "node {}: {} samples, one every {} ms, from {:.3} s to {:.3} s around the trigger",
            self.node,
            self.samples,
            self.period_s * 1e3,
            first.unwrap_or(&0.0),
            last.unwrap_or(&0.0),
        ))?;
        for curve in &self.channels {
            let values = curve.values.iter();
            let (low, high) = (values.clone().min(), values.max());
            let (low, high) = (low.unwrap_or(&0), high.unwrap_or(&0));
            console.say("")?;
            console.say(&format!("{}, {low} to {high}", curve.name))?;
            let values = curve.values.iter().map(|value| *value as f64).collect();
            console.say(&chart::in_characters(values, None))?;
        }
        Ok(())
    }

    fn table(&self) -> String {
        let titles = self.channels.iter().map(|curve| {
            let name = curve.name.replace('"', "\"\"");
            format!(",\"{name}\"")
        });
        let mut text = format!("time_s{}\n", titles.collect::<String>());
        for (sample, time) in self.time_s.iter().enumerate() {
            let values = self.channels.iter();
            let values = values.filter_map(|curve| curve.values.get(sample));
            let values = values.map(|value| format!(",{value}")).collect::<String>();
            text += &format!("{time:.9}{values}\n");
        }
        text
    }

    fn draw(&self, file: &Path) -> Result<(), String> {
        let start = self.time_s.first().copied().unwrap_or(0.0);
        let end = self.time_s.last().copied().unwrap_or(0.0) - start;
        let colours = COLOURS.into_iter().cycle();
        let charts = self.channels.iter().zip(colours).map(|(curve, colour)| {
            let times = self.time_s.iter().map(|time| (time - start) as f32);
            let values = curve.values.iter().map(|value| *value as f32);
            Chart::new(curve.name.clone(), colour, times.zip(values).collect())
        });
        let charts: Vec<Chart> = charts.collect();
        chart::as_svg(&charts, (end as f32).max(f32::EPSILON), file)
    }
}

fn unwritable(file: &Path, why: &str) -> Problem {
    Problem::Usage(format!("cannot write {}: {why}", file.display()))
}
