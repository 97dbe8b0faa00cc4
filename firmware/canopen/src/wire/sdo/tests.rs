use std::vec::Vec;

use proptest::prelude::*;

use super::*;

const OBJECT: Multiplexer = Multiplexer {
    index: 0x1017,
    sub: 0,
};

#[test]
fn s02_lengths_of_expedited_values() {
    let commands = [(1, 0x4F), (2, 0x4B), (3, 0x47), (4, 0x43)];
    for (length, command) in commands {
        let data = [1, 2, 3, 4];
        let payload = Payload::Expedited(&data[..length]);
        let frame = Response::InitiateUpload {
            object: OBJECT,
            payload,
        }
        .emit();
        assert_eq!(frame[0], command);
        assert_eq!(&frame[1..4], &[0x17, 0x10, 0]);
        assert_eq!(&frame[4..4 + length], &data[..length]);
        assert!(
            frame[4 + length..].iter().all(|byte| *byte == 0),
            "unused bytes are zero"
        );
    }
}

#[test]
fn s12_expedited_without_size() {
    let frame = [0x22, 0x17, 0x10, 0, 0xE8, 3, 0, 0];
    let payload = Payload::ExpeditedUnsized(&[0xE8, 3, 0, 0]);
    assert_eq!(
        Request::parse(&frame),
        Request::InitiateDownload {
            object: OBJECT,
            payload
        }
    );
}

#[test]
fn s22_length_of_segments() {
    for length in 0..=7_u8 {
        let data = [0xAA; 7];
        let data = &data[..usize::from(length)];
        let frame = Response::UploadSegment {
            toggle: true,
            data,
            last: true,
        }
        .emit();
        assert_eq!(frame[0], 0x11 | (7 - length) << 1);
    }
}

#[test]
fn b01_the_frames_of_a_block_download() {
    let object = Multiplexer {
        index: 0x2000,
        sub: 0,
    };
    let initiate = [0xC6, 0, 0x20, 0, 0x14, 0, 0, 0];
    let request = BlockRequest::InitiateDownload {
        object,
        crc: true,
        size: Some(20),
    };
    assert_eq!(Request::parse(&initiate), Request::Block(request));
    let end = [0xC5, 0x34, 0x10, 0, 0, 0, 0, 0];
    let request = BlockRequest::EndDownload {
        empty: 1,
        crc: 0x1034,
    };
    assert_eq!(Request::parse(&end), Request::Block(request));
    let response = BlockResponse::Acknowledge {
        seqno: 3,
        block_size: 127,
    };
    assert_eq!(response.emit(), [0xA2, 3, 0x7F, 0, 0, 0, 0, 0]);
}

#[test]
fn b03_the_frames_of_a_block_upload() {
    let initiate = [0xA0, 0, 0x10, 0, 0x14, 0, 0, 0];
    let object = Multiplexer {
        index: 0x1000,
        sub: 0,
    };
    let request = BlockRequest::InitiateUpload {
        object,
        crc: false,
        block_size: 20,
        threshold: 0,
    };
    assert_eq!(Request::parse(&initiate), Request::Block(request));
    let response = BlockResponse::InitiateUpload {
        object,
        crc: true,
        size: Some(4),
    };
    assert_eq!(response.emit(), [0xC6, 0, 0x10, 0, 4, 0, 0, 0]);
    let response = BlockResponse::EndUpload { empty: 3, crc: 0 };
    assert_eq!(response.emit(), [0xCD, 0, 0, 0, 0, 0, 0, 0]);
    let segment = [0x81, 0x91, 1, 0x0F, 0, 0, 0, 0];
    assert_eq!(BlockSegment::parse(&segment).emit(), segment);
}

/// A payload, its data kept apart because the view borrows it.
fn payload() -> impl Strategy<Value = (u8, Vec<u8>, u32)> {
    (
        0..4_u8,
        proptest::collection::vec(any::<u8>(), 1..=4),
        any::<u32>(),
    )
}

fn view<'a>(kind: u8, data: &'a [u8], four: &'a [u8; 4], size: u32) -> Payload<'a> {
    match kind {
        0 => Payload::Expedited(data),
        1 => Payload::ExpeditedUnsized(four),
        2 => Payload::Segmented(Some(size)),
        _ => Payload::Segmented(None),
    }
}

proptest! {
    #[test]
    fn requests_survive_the_bus(
        kind in 0..12_u8, index: u16, sub: u8, (shape, data, number) in payload(), toggle: bool, last: bool,
        part in proptest::collection::vec(any::<u8>(), 0..=7),
    ) {
        let object = Multiplexer { index, sub };
        let four = number.to_le_bytes();
        let request = match kind {
            0 => Request::InitiateDownload { object, payload: view(shape, &data, &four, number) },
            1 => Request::DownloadSegment { toggle, data: &part, last },
            2 => Request::InitiateUpload(object),
            3 => Request::UploadSegment { toggle },
            4 => Request::Abort { object, code: number },
            5 => Request::Block(BlockRequest::InitiateDownload { object, crc: toggle, size: last.then_some(number) }),
            6 => Request::Block(BlockRequest::EndDownload { empty: shape, crc: index }),
            7 => Request::Block(BlockRequest::InitiateUpload { object, crc: toggle, block_size: sub, threshold: shape }),
            8 => Request::Block(BlockRequest::EndUpload),
            9 => Request::Block(BlockRequest::Acknowledge { seqno: sub, block_size: shape }),
            10 => Request::Block(BlockRequest::StartUpload),
            _ => Request::Unknown(object),
        };
        let frame = request.emit();
        prop_assert_eq!(Request::parse(&frame), request);
    }

    #[test]
    fn responses_survive_the_bus(
        kind in 0..10_u8, index: u16, sub: u8, (shape, data, number) in payload(), toggle: bool, last: bool,
        part in proptest::collection::vec(any::<u8>(), 0..=7),
    ) {
        let object = Multiplexer { index, sub };
        let four = number.to_le_bytes();
        let response = match kind {
            0 => Response::InitiateUpload { object, payload: view(shape, &data, &four, number) },
            1 => Response::UploadSegment { toggle, data: &part, last },
            2 => Response::InitiateDownload(object),
            3 => Response::DownloadSegment { toggle },
            4 => Response::Block(BlockResponse::InitiateDownload { object, crc: toggle, block_size: shape }),
            5 => Response::Block(BlockResponse::Acknowledge { seqno: sub, block_size: shape }),
            6 => Response::Block(BlockResponse::EndDownload),
            7 => Response::Block(BlockResponse::InitiateUpload { object, crc: toggle, size: last.then_some(number) }),
            8 => Response::Block(BlockResponse::EndUpload { empty: shape, crc: index }),
            _ => Response::Abort { object, code: number },
        };
        let frame = response.emit();
        prop_assert_eq!(Response::parse(&frame), Some(response));
    }

    #[test]
    fn any_eight_bytes_are_a_request(frame: [u8; 8]) {
        let request = Request::parse(&frame);
        // What was understood means the same after a second trip.
        let again = request.emit();
        prop_assert_eq!(Request::parse(&again), request);
    }
}
