//! Each device against its own data sheet: a master that reads the file and tries every object, default and limit, every SDO form, PDO
//! type and remote frame, error control and NMT transition finds no difference.
//!
//! What is expected comes from the file, as [`od_gen`] reads it, and from CiA 301; no device has exceptions of its own.

mod network;
mod objects;
mod process_data;

use od_gen::model::{Entry, Model};
use tests::bare_node::BareNode;
use tests::drive::CompactBench;
use tests::line::Line;
use tests::{Bench, DriveBench};

/// The node-ID of all of them.
const NODE: u8 = 4;

/// The data sheet at this path.
fn read(path: &str) -> Model {
    od_gen::read(std::path::Path::new(path)).expect("a data sheet without mistakes")
}

/// "Refuse read on scan" and "refuse write on download" (ObjFlags, CiA 306): what a master that tries everything leaves alone.
fn is_for_reading(entry: &Entry) -> bool {
    entry.access.is_readable() && entry.flags & 0x2 == 0
}

fn is_for_writing(entry: &Entry) -> bool {
    entry.access.is_writable() && entry.flags & 0x1 == 0
}

/// The tests, for each device.
macro_rules! devices {
    ($($name:ident: $sheet:literal, $device:expr;)*) => {$(
        mod $name {
            use super::*;

            #[test]
            fn o01_each_object_is_what_the_data_sheet_says() {
                objects::are_what_the_data_sheet_says(&read($sheet), &mut $device);
            }

            #[test]
            fn o02_s05_and_s06_what_is_not_in_the_data_sheet_is_not_there() {
                objects::are_those_of_the_data_sheet(&read($sheet), &mut $device);
            }

            #[test]
            fn a_value_of_another_length_is_refused() {
                objects::have_their_length(&read($sheet), &mut $device);
            }

            #[test]
            fn values_beyond_a_limit_are_refused() {
                objects::have_their_limits(&read($sheet), &mut $device);
            }

            #[test]
            fn each_form_of_upload_gives_the_same() {
                objects::are_read_in_each_form(&read($sheet), &mut $device);
            }

            #[test]
            fn each_form_of_download_takes_what_was_read() {
                objects::are_written_in_each_form(&read($sheet), &mut $device);
            }

            #[test]
            fn requests_out_of_turn_are_refused() {
                objects::are_read_in_turn(&read($sheet), &mut $device);
            }

            #[test]
            fn each_transmission_type_is_taken_or_refused() {
                process_data::types_are_those_of_the_standard(&read($sheet), &mut $device);
            }

            #[test]
            fn each_synchronous_type_is_sent_when_it_is_due() {
                process_data::is_sent_by_sync(&read($sheet), &mut $device);
            }

            #[test]
            fn event_driven_types_keep_their_times() {
                process_data::is_sent_by_event(&read($sheet), &mut $device);
            }

            #[test]
            fn each_type_answers_a_remote_frame_or_not() {
                process_data::answers_remote_frames(&read($sheet), &mut $device);
            }

            #[test]
            fn each_synchronous_type_is_received_at_sync() {
                process_data::is_received_by_sync(&read($sheet), &mut $device);
            }

            #[test]
            fn each_object_is_mapped_as_the_data_sheet_says() {
                process_data::objects_are_mapped(&read($sheet), &mut $device);
            }

            #[test]
            fn dummies_are_those_of_the_data_sheet() {
                process_data::dummies_are_mapped(&read($sheet), &mut $device);
            }

            #[test]
            fn each_command_in_each_state_leads_where_it_should() {
                network::states_follow_commands(&mut $device);
            }

            #[test]
            fn the_device_tells_its_state_as_the_data_sheet_says() {
                network::state_is_told(&read($sheet), &mut $device);
            }

            #[test]
            fn a_node_that_is_lost_and_returns_is_told() {
                network::lost_nodes_are_told(&read($sheet), &mut $device);
            }
        }
    )*};
}

devices! {
    axis402: "../eds/axis402.eds", DriveBench::booted(NODE);
    compact: "../eds/compact.eds", CompactBench::booted(NODE);
    test_device: "eds/test-device.eds", Bench::node(NODE);
    basic_device: "eds/basic-device.eds", Line::<BareNode<tests::basic_device::Dictionary>>::bare(NODE);
    io_device: "../firmware/canopen/examples/io_device/io-device.eds", Line::<BareNode<tests::io_device::Dictionary>>::bare(NODE);
}
