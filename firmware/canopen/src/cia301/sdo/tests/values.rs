//! Values of every short length, sizes that are hidden, answers that come late, and what does not fit.

use std::vec::Vec;

use super::store::Store;
use super::{STREAM, STRING, TestServer, server};
use crate::cia301::sdo::server::Server;
use crate::cia301::sdo::{AbortCode, TIME_OUT};
use crate::od::Unused;
use crate::time::Instant;
use crate::wire::sdo::{Multiplexer, Payload, Request, Response};

const NOW: Instant = Instant::from_ticks(0);

fn abort(object: Multiplexer, code: AbortCode) -> [u8; 8] {
    Response::Abort {
        object,
        code: code.get(),
    }
    .emit()
}

/// The answer to a request.
fn ask(server: &mut TestServer, store: &mut Store, request: Request<'_>) -> Option<[u8; 8]> {
    server.answer(&request.emit(), NOW, store)
}

/// Uploads as a client does; the size that was told, and the data.
fn upload(
    server: &mut TestServer,
    store: &mut Store,
    object: Multiplexer,
) -> (Option<u32>, Vec<u8>) {
    let answer = ask(server, store, Request::InitiateUpload(object)).unwrap();
    let size = match Response::parse(&answer) {
        Some(Response::InitiateUpload {
            payload: Payload::Expedited(data),
            ..
        }) => return (Some(data.len() as u32), data.to_vec()),
        Some(Response::InitiateUpload {
            payload: Payload::Segmented(size),
            ..
        }) => size,
        other => panic!("{other:?}"),
    };
    let mut value = Vec::new();
    for toggle in [false, true].into_iter().cycle() {
        let answer = ask(server, store, Request::UploadSegment { toggle }).unwrap();
        let Some(Response::UploadSegment { data, last, .. }) = Response::parse(&answer) else {
            panic!("{answer:02X?}");
        };
        value.extend_from_slice(data);
        if last {
            break;
        }
    }
    (size, value)
}

#[test]
fn s22_every_length_is_read_whole() {
    for hides_size in [false, true] {
        for length in 0..=30 {
            let value: Vec<u8> = (1..=length).collect();
            let mut store = Store {
                value: value.clone(),
                hides_size,
                ..Store::default()
            };
            for object in [STRING, STREAM] {
                let (size, read) = upload(&mut server(), &mut store, object);
                assert_eq!(read, value);
                // What fits in the first frame has its size there.
                let is_hidden = object == STREAM && hides_size && !(1..=4).contains(&length);
                assert_eq!(size, (!is_hidden).then_some(length.into()));
            }
        }
    }
}

#[test]
fn a_short_stream_is_written_by_one_frame() {
    for length in 1..=4 {
        let value: Vec<u8> = (1..=length).collect();
        let mut store = Store::default();
        let request = Request::InitiateDownload {
            object: STREAM,
            payload: Payload::Expedited(&value),
        };
        let answer = ask(&mut server(), &mut store, request);
        assert_eq!(answer, Some(Response::InitiateDownload(STREAM).emit()));
        assert_eq!(store.value, value);
    }
}

#[test]
fn s34_a_value_in_ram_is_a_snapshot() {
    let mut store = Store {
        value: (1..=10).collect(),
        ..Store::default()
    };
    let mut server = server();
    ask(&mut server, &mut store, Request::InitiateUpload(STRING));
    store.value = std::vec![0; 10];
    let answer = ask(
        &mut server,
        &mut store,
        Request::UploadSegment { toggle: false },
    );
    assert_eq!(answer, Some([0, 1, 2, 3, 4, 5, 6, 7]));
}

#[test]
fn a_value_beyond_the_buffer_is_out_of_memory_and_not_cut() {
    let long = [0x55; 10];
    let mut server = Server::<[u8; 8]>::UNUSED;
    server.reset();
    let mut store = Store::default();
    let refusal = Some(abort(STRING, AbortCode::OutOfMemory));
    let open = |size| Request::InitiateDownload {
        object: STRING,
        payload: Payload::Segmented(size),
    };
    assert_eq!(
        server.answer(&open(Some(10)).emit(), NOW, &mut store),
        refusal
    );
    server.answer(&open(None).emit(), NOW, &mut store);
    let segment = |toggle, data| {
        Request::DownloadSegment {
            toggle,
            data,
            last: toggle,
        }
        .emit()
    };
    server.answer(&segment(false, &long[..7]), NOW, &mut store);
    assert_eq!(
        server.answer(&segment(true, &long[7..]), NOW, &mut store),
        refusal
    );
    assert!(store.value.is_empty());
    store.value = long.to_vec();
    let read = Request::InitiateUpload(STRING).emit();
    assert_eq!(server.answer(&read, NOW, &mut store), refusal);
}

#[test]
fn s26_the_time_out_aborts_once() {
    let mut server = server();
    let mut store = Store {
        value: std::vec![1; 20],
        ..Store::default()
    };
    ask(&mut server, &mut store, Request::InitiateUpload(STRING));
    let just_before = NOW + TIME_OUT - crate::Duration::from_ticks(1);
    assert_eq!(server.tell(just_before, &mut store), None);
    assert_eq!(
        server.tell(NOW + TIME_OUT, &mut store),
        Some(abort(STRING, AbortCode::TimedOut))
    );
    assert_eq!(server.tell(NOW + TIME_OUT, &mut store), None);
}

#[test]
fn the_answer_to_a_write_may_come_later() {
    let later = NOW + TIME_OUT * 100;
    let mut server = server();
    let mut store = Store {
        is_slow: true,
        ..Store::default()
    };
    let write = Request::InitiateDownload {
        object: STRING,
        payload: Payload::Expedited(&[1, 2, 3, 4]),
    };
    let written = Response::InitiateDownload(STRING).emit();
    let refused = abort(STRING, AbortCode::HardwareError);
    for (result, answer) in [(Ok(()), written), (Err(AbortCode::HardwareError), refused)] {
        assert_eq!(ask(&mut server, &mut store, write), None);
        assert_eq!(server.tell(later, &mut store), None, "there is no time-out");
        assert_eq!(server.done(STREAM, Ok(())), None);
        assert_eq!(server.done(STRING, result), Some(answer));
        assert_eq!(server.done(STRING, result), None, "once");
    }
    // A client that gives up, or asks for something else, gets no answer to what it asked before.
    let give_up = Request::Abort {
        object: STRING,
        code: 0,
    };
    for other in [give_up, Request::InitiateUpload(STRING)] {
        assert_eq!(ask(&mut server, &mut store, write), None);
        ask(&mut server, &mut store, other);
        assert_eq!(server.done(STRING, Ok(())), None);
    }
}
