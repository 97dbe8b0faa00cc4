//! The store on a flash whose power can be cut at any byte, and that somebody else writes into.

mod damage;
mod factory_reset;
mod flash;
mod parameters;
mod settings;
mod stored;

use flash::{Flash, Refusal};
