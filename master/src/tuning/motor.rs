//! What a drive has measured of its motor, and where it is written.

use serde::Serialize;

use super::Host;
use crate::Failure;
use crate::axis402::{Node, Problem};
use crate::data_sheet::Address;

/// A motor as it was measured.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Motor {
    /// In Ω.
    pub resistance: f64,
    /// In H.
    pub inductance_along: f64,
    /// In H.
    pub inductance_across: f64,
    /// In V·s.
    pub flux: f64,
    /// Electrical turns in one of the motor.
    pub pole_pairs: u32,
    /// 1 or −1: which way the encoder counts.
    pub direction: i8,
    /// The electrical angle where the encoder is at 0, in degrees.
    pub angle: f64,
    /// Of all that turns, in kg·m².
    pub inertia: f64,
    /// In N·m.
    pub friction: f64,
    /// 60F9h:1 and 2 and 60FBh:1, in 1/s.
    pub gains: [u32; 3],
    /// The values of [`PARAMETERS`], as the drive has told them.
    #[serde(skip)]
    pub values: [u32; 9],
}

/// An object that is set to what was measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameter {
    /// Where it is written, and in how many bytes.
    pub address: Address,
    length: usize,
    /// The sub-index of 20C1h where it was found.
    found: u8,
    /// What it is called.
    pub name: &'static str,
    /// The unit that people know.
    pub unit: &'static str,
    /// What a count of the object is of it.
    pub factor: f64,
}

const fn parameter(
    (index, sub, length): (u16, u8, usize),
    found: u8,
    name: &'static str,
    (unit, factor): (&'static str, f64),
) -> Parameter {
    Parameter {
        address: Address::new(index, sub),
        length,
        found,
        name,
        unit,
        factor,
    }
}

/// What is written: the motor that the loops go by, and their gains.
pub const PARAMETERS: [Parameter; 9] = [
    parameter((0x20C2, 1, 4), 3, "Resistance", ("Ω", 1e-6)),
    parameter(
        (0x20C2, 2, 4),
        4,
        "Inductance along the magnet",
        ("mH", 1e-6),
    ),
    parameter(
        (0x20C2, 3, 4),
        5,
        "Inductance across the magnet",
        ("mH", 1e-6),
    ),
    parameter((0x20C2, 4, 4), 6, "Flux", ("mV·s", 1e-6)),
    parameter((0x20C2, 5, 4), 10, "Inertia", ("kg·mm²", 1e-3)),
    parameter((0x20C2, 6, 4), 11, "Friction", ("mN·m", 1e-3)),
    parameter((0x60F9, 1, 2), 12, "Gain of the velocity", ("1/s", 1.0)),
    parameter((0x60F9, 2, 2), 13, "Its integral", ("1/s", 1.0)),
    parameter((0x60FB, 1, 2), 14, "Gain of the position", ("1/s", 1.0)),
];

/// An entry of 20C1h.
pub(super) const fn result(sub: u8) -> Address {
    Address::new(0x20C1, sub)
}

impl Motor {
    /// What 20C1h tells, read by `value`.
    pub(super) fn read(
        mut value: impl FnMut(Address) -> Result<u32, Problem>,
    ) -> Result<Self, Problem> {
        let mut values = [0; 9];
        for (parameter, found) in PARAMETERS.iter().zip(&mut values) {
            *found = value(result(parameter.found))?;
        }
        let [
            resistance,
            along,
            across,
            flux,
            inertia,
            friction,
            gains @ ..,
        ] = values;
        let direction = value(result(8))?;
        Ok(Self {
            resistance: f64::from(resistance) * 1e-6,
            inductance_along: f64::from(along) * 1e-9,
            inductance_across: f64::from(across) * 1e-9,
            flux: f64::from(flux) * 1e-9,
            pole_pairs: value(result(7))?,
            direction: if direction == 1 { 1 } else { -1 },
            angle: f64::from(value(result(9))?) * 360.0 / 65_536.0,
            inertia: f64::from(inertia) * 1e-9,
            friction: f64::from(friction) * 1e-6,
            gains,
            values,
        })
    }
}

/// What the objects of [`PARAMETERS`] hold; 0 is what the drive is built with.
///
/// # Errors
/// [`Problem::Failed`] if the node does not answer, or has no such object.
pub fn values<H: Host>(host: &mut H, node: &Node) -> Result<[u32; 9], Problem> {
    let mut values = [0; 9];
    for (parameter, value) in PARAMETERS.iter().zip(&mut values) {
        let bytes = node.upload(host.master(), parameter.address);
        *value = number(&bytes.map_err(|failure| Problem::with_node(node.id, failure))?);
    }
    Ok(values)
}

/// Writes what was found of a motor: all of it, or nothing. The motor has no power: what it goes by is taken over then.
///
/// # Errors
/// [`Problem::Failed`] if the motor has power, or the node refuses a value.
pub fn write<H: Host>(host: &mut H, node: &Node, motor: &Motor) -> Result<(), Problem> {
    let told = |failure: Failure| Problem::with_node(node.id, failure);
    let statusword = node.upload(host.master(), Address::new(0x6041, 0));
    if has_power(number(&statusword.map_err(told)?)) {
        let text = format!("node {}: its motor has power: take it away first", node.id);
        return Err(Problem::Failed(text));
    }
    let before = values(host, node)?;
    for (place, parameter) in PARAMETERS.iter().enumerate() {
        let value = motor.values.get(place).copied().unwrap_or_default();
        if let Err(failure) = put(host, node, parameter, value) {
            for (parameter, value) in PARAMETERS.iter().zip(before).take(place) {
                // Whoever refuses this too is asked for no more.
                let _ = put(host, node, parameter, value);
            }
            return Err(told(failure));
        }
    }
    Ok(())
}

fn put<H: Host>(
    host: &mut H,
    node: &Node,
    parameter: &Parameter,
    value: u32,
) -> Result<(), Failure> {
    let bytes = value.to_le_bytes();
    let bytes = bytes.get(..parameter.length).unwrap_or_default();
    node.download(host.master(), parameter.address, bytes)
}

/// Whether a drive with this 6041h has its power stage on: switched on, operation enabled, quick stop active, on its way to a fault.
pub fn has_power(statusword: u32) -> bool {
    statusword & 0x4F == 0x07 || statusword & 0x6F == 0x23 || statusword & 0x4F == 0x0F
}

/// A number without sign, as it travels.
pub(super) fn number(bytes: &[u8]) -> u32 {
    let number = (bytes.iter().rev()).fold(0_u64, |number, byte| number << 8 | u64::from(*byte));
    u32::try_from(number).unwrap_or(u32::MAX)
}
