//! The cases of CiA 301, 302, 303 and 305: what goes in on the bus, what comes out, at which time.
//!
//! One module per service, all in one program, as linking it takes longer than running it; the name of a listed case begins with its id.

mod device;

mod can_controller;
mod configuration_date;
mod deadlines;
mod emergency;
mod emergency_consumer;
mod emergency_states;
mod features;
mod guarding;
mod habits;
mod heartbeat;
mod heartbeat_consumer;
mod identifiers;
mod indicators;
mod lss;
mod lss_and_nmt;
mod nmt;
mod parameters;
mod parameters_loading;
mod pdo;
mod pdo_parameters;
mod pdo_times;
mod random_frames;
mod receive_errors;
mod sdo;
mod sdo_block_download;
mod sdo_block_upload;
mod sdo_endings;
mod sdo_servers;
mod startup;
mod sync;
