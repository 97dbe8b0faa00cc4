//! A drive with a servo measures its motor, and how its loops answer (20C0h to 20C2h, `docs/servo.md`).
//!
//! The motor moves. What is changed for it is put back, and the motor has no power then; what is found is written only by [`write()`]. Who wants
//! it is a [`Host`]: it has the master, lets time pass, and may end the work at any moment.

mod bench;
mod motor;
mod response;

use canopen::Duration;
use serde::Serialize;

use crate::axis402::{Node, Problem};
use crate::data_sheet::DataSheet;
use crate::{Line, Master};

pub use motor::{Motor, PARAMETERS, Parameter, has_power, values, write};
pub use response::{Point, response};

/// What is wanted. The default is nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Wanted {
    /// The motor is measured.
    pub motor: bool,
    /// The current of the measurement, in thousandths of the rated one; what the drive has without it.
    pub current: Option<u16>,
    /// The bandwidth of the velocity loop in 1/s; what the drive thinks fit without it.
    pub bandwidth: Option<u16>,
    /// What is found of the motor is written.
    pub writes: bool,
    /// What the speed makes of a torque, over the frequency.
    pub response: bool,
    /// A move by a hundredth of a turn at once.
    pub step: bool,
}

/// What was found.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Found {
    /// The motor, if it was measured.
    #[serde(flatten)]
    pub motor: Option<Motor>,
    /// What the speed makes of a torque; empty if nobody wanted it.
    pub response: Vec<Point>,
    /// The position over time in s, as wanted and as it was, in increments from where it began; empty if nobody wanted it.
    pub step: Vec<(f64, i32, i32)>,
    /// What was found of the motor was written.
    pub is_written: bool,
}

/// What is under way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// The drive gets its power.
    Enabling,
    /// Resistance and inductances.
    Winding,
    /// The field turns the rotor: pole pairs, direction and angle of the encoder.
    Field,
    /// Torques push it to and fro: flux, inertia, friction.
    Strokes,
    /// The frequency response.
    Response,
    /// The step.
    Step,
}

impl Stage {
    /// For a person.
    pub fn words(self) -> &'static str {
        match self {
            Self::Enabling => "the drive gets its power",
            Self::Winding => "resistance and inductances",
            Self::Field => "the field turns the rotor",
            Self::Strokes => "torques push the rotor to and fro",
            Self::Response => "frequency response",
            Self::Step => "step of the position",
        }
    }
}

/// Who wants it.
pub trait Host {
    /// Its bus.
    type Line: Line;

    /// Its master.
    fn master(&mut self) -> &mut Master<Self::Line>;

    /// Lets time pass.
    ///
    /// # Errors
    /// When the work shall end.
    fn pause(&mut self, span: Duration) -> Result<(), Problem>;

    /// Hears how far it is.
    fn at(&mut self, stage: Stage);

    /// The work is over, or was ended: now the motor loses its power, and all is put back.
    fn conclude(&mut self) {}
}

/// Whether a drive with this data sheet can do it; another maker's 20C0h is something else.
pub fn is_possible(sheet: &DataSheet) -> bool {
    let is_ours = |(index, name)| {
        let object = sheet.object(index);
        object.is_some_and(|object| object.name == name)
    };
    [
        (0x20C0, "Tuning"),
        (0x20C1, "Tuning result"),
        (0x20C2, "Motor data"),
    ]
    .into_iter()
    .all(is_ours)
}

/// Does it.
///
/// # Errors
/// [`Problem::Failed`] if the drive cannot do it, is in operation already, or does not succeed; what [`Host::pause`] says.
pub fn tune<H: Host>(host: &mut H, node: &Node, wanted: &Wanted) -> Result<Found, Problem> {
    bench::Bench::new(host, node).run(wanted)
}
