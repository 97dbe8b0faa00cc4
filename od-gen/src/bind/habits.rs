//! The habits that a binding may name: fields of `canopen::od::Habits` and `cia402::Habits`, as Rust has their values.

use toml::Value;

/// Whose habit it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Owner {
    /// The node: `canopen::od::Habits`.
    Node,
    /// The drive: `cia402::Habits`.
    Drive,
    /// Where settings are objects: `cia402::NetworkObjects`.
    Network,
    /// It is a feature: block transfer.
    Features,
}

/// What a habit is given in a binding.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Flag,
    AbortCode,
    /// An abort code where the standard has none.
    OtherAbortCode,
    NodeId,
    BitRate,
    Object,
    /// A number for each bit rate.
    BitRates,
}

/// A habit of the firmware.
#[derive(Debug, PartialEq, Eq)]
pub struct Known {
    /// Its name in a binding, mostly that of the field.
    pub name: &'static str,
    /// Whose it is.
    pub owner: Owner,
    kind: Kind,
}

/// A habit with a value, an expression of Rust.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Habit {
    /// Which one.
    pub known: &'static Known,
    /// The value.
    pub value: String,
}

const fn known(owner: Owner, name: &'static str, kind: Kind) -> Known {
    Known { name, owner, kind }
}

/// Every habit.
pub static KNOWN: [Known; 38] = [
    known(Owner::Node, "node_id", Kind::NodeId),
    known(Owner::Node, "bit_rate", Kind::BitRate),
    known(Owner::Node, "node_id_at_once", Kind::Flag),
    known(Owner::Node, "short_sdo_requests", Kind::Flag),
    known(Owner::Node, "maps_while_valid", Kind::Flag),
    known(Owner::Node, "tells_of_the_rest", Kind::Flag),
    known(Owner::Node, "acyclic_is_each_sync", Kind::Flag),
    known(Owner::Node, "short_sizes", Kind::Flag),
    known(Owner::Node, "mapped_length_of_0", Kind::Flag),
    known(Owner::Node, "lss_100_kbit", Kind::Flag),
    known(Owner::Node, "receives_at_nth_sync", Kind::Flag),
    known(Owner::Node, "stored_identifiers_stay", Kind::Flag),
    known(Owner::Node, "event_timer_in_100_us", Kind::Flag),
    known(Owner::Node, "tells_its_state", Kind::Flag),
    known(Owner::Node, "no_remote_requests", Kind::Flag),
    known(Owner::Node, "wrong_signature", Kind::AbortCode),
    known(Owner::Node, "wrong_history_count", Kind::AbortCode),
    known(Owner::Node, "missing_mapped_object", Kind::OtherAbortCode),
    known(Owner::Node, "mapping_too_long", Kind::AbortCode),
    known(Owner::Drive, "voltage_needs_power", Kind::Flag),
    known(Owner::Drive, "power_when_switched_on", Kind::Flag),
    known(Owner::Drive, "quick_stop_bit_while_disabled", Kind::Flag),
    known(Owner::Drive, "is_always_remote", Kind::Flag),
    known(Owner::Drive, "third_set_point_replaces", Kind::Flag),
    known(Owner::Drive, "velocity_without_ramp_bits", Kind::Flag),
    known(Owner::Drive, "following_error_is_told", Kind::Flag),
    known(Owner::Drive, "supply_gates_ready", Kind::Flag),
    known(Owner::Drive, "start_speed", Kind::Flag),
    known(Owner::Drive, "lock_is_bit_8", Kind::Flag),
    known(Owner::Drive, "velocity_in_rpm", Kind::Flag),
    known(Owner::Drive, "velocity_has_polarity", Kind::Flag),
    known(Owner::Drive, "home_switch_elsewhere", Kind::Flag),
    known(Owner::Drive, "compares_positions", Kind::Flag),
    known(Owner::Network, "node_id_object", Kind::Object),
    known(Owner::Network, "bit_rate_object", Kind::Object),
    known(Owner::Network, "bit_rate_numbers", Kind::BitRates),
    known(Owner::Network, "serial_number_object", Kind::Object),
    known(Owner::Features, "block_transfer", Kind::Flag),
];

/// The names of `canopen::cia301::sdo::AbortCode`.
const ABORT_CODES: [(i64, &str); 16] = [
    (0x0504_0001, "InvalidCommand"),
    (0x0601_0000, "UnsupportedAccess"),
    (0x0601_0002, "ReadOnly"),
    (0x0602_0000, "NoObject"),
    (0x0604_0041, "NotMappable"),
    (0x0604_0042, "PdoLengthExceeded"),
    (0x0604_0043, "ParameterIncompatible"),
    (0x0606_0000, "HardwareError"),
    (0x0607_0010, "LengthMismatch"),
    (0x0609_0011, "NoSubIndex"),
    (0x0609_0030, "InvalidValue"),
    (0x0609_0031, "ValueTooHigh"),
    (0x0609_0032, "ValueTooLow"),
    (0x0800_0000, "General"),
    (0x0800_0020, "NotTransferable"),
    (0x0800_0022, "DeviceState"),
];

const BIT_RATES: [i64; 9] = [1000, 800, 500, 250, 125, 100, 50, 20, 10];

impl Known {
    /// What it is to be given, for people.
    pub(super) const fn wanted(&self) -> &'static str {
        match self.kind {
            Kind::Flag => "true or false",
            Kind::AbortCode | Kind::OtherAbortCode => "an abort code, such as 0x06090030",
            Kind::NodeId => "a number from 1 to 127",
            Kind::BitRate => "a bit rate in kbit/s",
            Kind::Object => "an object, such as \"2009h\" or \"2510h:1\"",
            Kind::BitRates => "numbers of bit rates, such as { 130 = 20 }",
        }
    }

    /// A value as Rust has it; `None` for one that it cannot be.
    pub(super) fn value(&self, value: &Value) -> Option<String> {
        match self.kind {
            Kind::Flag => value.as_bool().map(|flag| flag.to_string()),
            Kind::AbortCode => abort_code(value),
            Kind::OtherAbortCode => abort_code(value).map(|code| format!("Some({code})")),
            Kind::NodeId => {
                let number = value.as_integer()?;
                (1..=127).contains(&number).then(|| number.to_string())
            }
            Kind::BitRate => {
                let rate = value.as_integer()?;
                BIT_RATES.contains(&rate).then(|| rate.to_string())
            }
            Kind::Object => {
                let (index, sub) = super::entry(value.as_str()?)?;
                Some(format!("(0x{index:04X}, {sub})"))
            }
            Kind::BitRates => {
                let mut pairs = Vec::new();
                for (number, rate) in value.as_table()? {
                    let number: u32 = number.parse().ok()?;
                    let rate = rate.as_integer()?;
                    let index = BIT_RATES.iter().position(|own| *own == rate)?;
                    pairs.push((number, index));
                }
                pairs.sort_unstable();
                Some(format!("&{pairs:?}"))
            }
        }
    }
}

fn abort_code(value: &Value) -> Option<String> {
    let number = value.as_integer()?;
    let (_, name) = ABORT_CODES.iter().find(|(code, _)| *code == number)?;
    Some(format!("::canopen::cia301::sdo::AbortCode::{name}"))
}
