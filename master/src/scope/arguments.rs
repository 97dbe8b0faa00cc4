//! The command line of `sim scope`.

use std::path::PathBuf;

use canopen::Duration;

use super::{Before, Request};
use crate::axis402::{Bus, Sheet};
use crate::data_sheet::DataSheet;

/// What to record, and how to show it.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    #[command(flatten)]
    pub(crate) bus: Bus,
    /// The node-ID of the drive
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(1..=127))]
    pub(crate) node: u8,
    /// Through which SDO server of the drive, where another master uses the first; 1200h + N - 1 has its identifiers
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(1..=128))]
    pub(crate) sdo_server: Option<u8>,
    #[command(flatten)]
    pub(crate) sheet: Sheet,
    /// Up to eight objects, by index or by name; by default what the drive has in 20D1h
    #[arg(long, value_name = "OBJECT,OBJECT,...", value_delimiter = ',')]
    channels: Option<Vec<String>>,
    /// A sample every so many control ticks, by default 1
    #[arg(long, value_name = "TICKS", value_parser = clap::value_parser!(u16).range(1..))]
    divider: Option<u16>,
    /// How many samples; by default 0, as many as the drive has room for
    #[arg(long, value_name = "N")]
    samples: Option<u16>,
    /// How many of them are older than the trigger, as a number or in per cent; by default 20%, and none where the trigger is `now`
    #[arg(long, value_name = "N or N%", value_parser = before)]
    pre: Option<Before>,
    /// now, fault, OBJECT>LEVEL, OBJECT<LEVEL, OBJECT~LEVEL (either way), OBJECT#BIT, OBJECT#BIT=0, or drive for all that the drive
    /// has in 20D0h to 20D2h and is not said here
    #[arg(long, value_name = "TRIGGER", default_value = "now")]
    trigger: String,
    /// How long to wait for the recording, in seconds
    #[arg(long, value_name = "S", default_value_t = 60, value_parser = clap::value_parser!(u32).range(1..=86_400))]
    wait: u32,
    /// Print one JSON object
    #[arg(long)]
    pub(crate) json: bool,
    /// Write time and values as comma-separated values
    #[arg(long, value_name = "FILE")]
    pub(crate) csv: Option<PathBuf>,
    /// Write a picture of each channel as SVG
    #[arg(long, value_name = "FILE.svg")]
    pub(crate) plot: Option<PathBuf>,
}

impl Arguments {
    /// What they ask of a drive with this data sheet.
    pub(super) fn request(&self, sheet: &DataSheet) -> Result<Request, String> {
        Request::parse(
            self.channels.as_deref(),
            &self.trigger,
            self.divider,
            self.samples,
            self.pre,
            Duration::from_ticks(u64::from(self.wait) * 1_000_000),
            sheet,
        )
    }
}

fn before(text: &str) -> Result<Before, String> {
    let wrong = || "a number of samples, or 0% to 99%".to_owned();
    match text.strip_suffix('%') {
        Some(percent) => {
            let percent = percent.trim().parse().ok().filter(|percent| *percent < 100);
            percent.map(Before::Percent).ok_or_else(wrong)
        }
        None => text.parse().map(Before::Samples).map_err(|_| wrong()),
    }
}
