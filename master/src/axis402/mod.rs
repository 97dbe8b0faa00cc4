//! `axis402`: a CANopen master on the command line, for real buses: find devices, number them by LSS, read and write their objects,
//! watch the traffic.
//!
//! It speaks to any vendor's device: nothing here knows a drive but by its data sheet. Each command is a function of a
//! [`crate::Master`] and a [`Console`]; the tests run them on the simulated bus, [`run`] on an adapter.

mod arguments;
mod bit_rate;
mod configuration;
mod console;
mod lss;
mod monitor;
mod nmt;
mod node;
mod object;
mod panel;
mod problem;
mod run;
mod save;
mod scan;
mod tune;
#[cfg(test)]
mod walk_through;

pub use arguments::Bus;
pub(crate) use arguments::Sheet;
pub use bit_rate::{BitRateSwitch, store_settings, switch_bit_rate};
pub use configuration::{dump, load};
pub use console::Console;
pub use lss::{Numbering, Setting, find, number, set};
pub use monitor::{Watch, monitor};
pub use nmt::nmt;
pub use node::Node;
pub use object::{fetch, put, read, write};
pub use panel::panel;
pub use problem::Problem;
pub(crate) use run::{explain, read_sheet};
pub use run::{go_on_bus, read_data_sheet, run};
pub use save::{Group, save};
pub use scan::{Description, Found, present, scan};
pub use tune::{Tuning, tune};
