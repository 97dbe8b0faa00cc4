//! Electronic data sheets (CiA 306, and CiA 311 in XML) in, typed static object dictionaries in Rust out.
//!
//! A data sheet is the only source of an object dictionary: names, types, access, defaults, limits and PDO mapping flags come
//! from it, and wrong use is a compile error. [`parse()`] reads and checks, [`generate()`] writes Rust, and [`build`] does both for a
//! build script. Everything that is wrong with a data sheet is reported in one run, each with its line; what this reader does
//! not know is a warning, never dropped in silence.
//!
//! ```
//! let text = "[FileInfo]\nFileName=empty.eds\n[DeviceInfo]\n[MandatoryObjects]\nSupportedObjects=0\n";
//! let findings = od_gen::parse("empty.eds", text).unwrap_err();
//! assert_eq!(
//!     findings[0].to_string(),
//!     "empty.eds:1:1: error[missing-mandatory-object]: the mandatory object 1000h is missing"
//! );
//! ```
#![forbid(unsafe_code)]

pub mod bind;
mod build_script;
pub mod convert;
mod data_type;
pub mod dcf;
mod diagnostic;
pub mod diff;
#[cfg(feature = "doc")]
pub mod doc;
mod document;
pub mod files;
mod fix;
mod generate;
mod json;
pub mod model;
pub mod network;
mod number;
mod parse;
mod print;
mod recipe;
mod report;
pub mod rules;
mod source;
mod spelling;
#[cfg(feature = "process")]
pub mod standard_output;
pub mod transfer;
mod xdd;

pub use bind::BindingReport;
pub use build_script::build;
pub use data_type::DataType;
pub use diagnostic::{Colour, Diagnostic, Exemption, Severity, allowances_beside, render};
pub use fix::fix;
pub use generate::{Figures, Identity, Options, generate, misfits};
pub use json::json;
pub use model::Model;
pub use parse::LARGEST_VALUE;
pub use print::{format, print};
pub use report::{ReadError, Report, parse, read};
pub use rules::{Class, Rule};
pub use source::{Source, Span};
pub use xdd::write as print_xdd;
