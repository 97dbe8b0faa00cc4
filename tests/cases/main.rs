//! The cases: what goes in on the bus, what comes out, at which time.
//!
//! One module per service; the name of a listed case begins with its id.

mod can_layer;
mod commissioning;
mod controller;
mod data_sheet;
mod detection;
mod following_error;
mod golden;
mod guarding;
mod heartbeat;
mod homing;
mod lost_steps;
mod lss;
mod lss_many_drives;
mod lss_nmt_states;
mod lss_power_cuts;
mod model;
mod modes;
mod mpdo;
mod nmt;
mod nmt_startup;
mod option_codes;
mod parameters;
mod pdo;
mod pdo_services;
mod profile_position;
mod profile_velocity;
mod random_frames;
mod ros2_canopen;
mod sdo;
mod sdo_block_download;
mod sdo_block_upload;
mod sdo_domains;
mod sdo_random;
mod sdo_servers;
mod seeded;
mod set_points;
mod state_machine;
mod storage;
mod sync_emergency;
mod sync_producer;
mod time;
mod units;
mod velocity;
mod walk_through;
