use std::vec::Vec;

use proptest::prelude::*;

use super::*;
use crate::od::{Attributes, DataType, Entry};
use crate::time::Instant;
use crate::wire::sdo::{Multiplexer, Payload, Request, Response};

/// One string, longer than the buffer of the server.
struct OneString(Vec<u8>);

static STRING: Entry = Entry {
    index: 0x2000,
    sub: 0,
    data_type: DataType::OctetString,
    offset: 0,
    size: 200,
    attributes: Attributes(Attributes::READ | Attributes::WRITE),
    limits: Entry::NO_LIMITS,
};

const OBJECT: Multiplexer = Multiplexer {
    index: 0x2000,
    sub: 0,
};
const NOW: Instant = Instant::from_ticks(0);

impl Objects for OneString {
    fn read(&mut self, _: Multiplexer) -> Result<&[u8], AbortCode> {
        Ok(&self.0)
    }

    fn writable(&mut self, _: Multiplexer) -> Result<&'static Entry, AbortCode> {
        Ok(&STRING)
    }

    fn write(&mut self, _: &'static Entry, value: &[u8]) -> Result<Completion, AbortCode> {
        self.0 = value.to_vec();
        Ok(Completion::Now)
    }
}

/// Downloads a value as a client does; the abort code if it is refused.
fn download(
    server: &mut Server,
    objects: &mut OneString,
    value: &[u8],
    size: Option<u32>,
) -> Result<(), u32> {
    let mut ask = |request: Request<'_>| {
        let answer = server.receive(&request.emit(), NOW, objects).unwrap();
        match Response::parse(&answer).unwrap() {
            Response::Abort { code, .. } => Err(code),
            _ => Ok(()),
        }
    };
    ask(Request::InitiateDownload {
        object: OBJECT,
        payload: Payload::Segmented(size),
    })?;
    let mut segments: Vec<&[u8]> = value.chunks(7).collect();
    if segments.is_empty() {
        segments.push(&[]);
    }
    let count = segments.len();
    for (number, data) in segments.into_iter().enumerate() {
        ask(Request::DownloadSegment {
            toggle: number % 2 == 1,
            data,
            last: number + 1 == count,
        })?;
    }
    Ok(())
}

/// Uploads a value as a client does.
fn upload(server: &mut Server, objects: &mut OneString) -> Result<Vec<u8>, u32> {
    let answer = server
        .receive(&Request::InitiateUpload(OBJECT).emit(), NOW, objects)
        .unwrap();
    let size = match Response::parse(&answer).unwrap() {
        Response::InitiateUpload {
            payload: Payload::Expedited(data),
            ..
        } => return Ok(data.to_vec()),
        Response::InitiateUpload {
            payload: Payload::Segmented(Some(size)),
            ..
        } => size,
        Response::Abort { code, .. } => return Err(code),
        other => panic!("{other:?}"),
    };
    let mut value = Vec::new();
    for number in 0.. {
        let answer = server
            .receive(
                &Request::UploadSegment {
                    toggle: number % 2 == 1,
                }
                .emit(),
                NOW,
                objects,
            )
            .unwrap();
        let Some(Response::UploadSegment { toggle, data, last }) = Response::parse(&answer) else {
            panic!("{answer:02X?}");
        };
        assert_eq!(toggle, number % 2 == 1);
        value.extend_from_slice(data);
        if last {
            break;
        }
    }
    assert_eq!(value.len(), size as usize);
    Ok(value)
}

proptest! {
    #[test]
    fn what_is_written_in_segments_is_read_in_segments(
        value in proptest::collection::vec(any::<u8>(), 0..=SDO_BUFFER), tell_size: bool,
    ) {
        let mut server = Server::new();
        let mut objects = OneString(Vec::new());
        let size = tell_size.then_some(value.len() as u32);
        prop_assert_eq!(download(&mut server, &mut objects, &value, size), Ok(()));
        prop_assert_eq!(&objects.0, &value);
        prop_assert_eq!(upload(&mut server, &mut objects), Ok(value));
        prop_assert_eq!(server.deadline(), crate::time::NEVER);
    }
}

#[test]
fn a_value_beyond_the_buffer_is_out_of_memory_and_not_cut() {
    let long = [0x55; SDO_BUFFER + 1];
    let mut server = Server::new();
    let mut objects = OneString(Vec::new());
    let out_of_memory = AbortCode::OutOfMemory.get();
    assert_eq!(
        download(&mut server, &mut objects, &long, Some(long.len() as u32)),
        Err(out_of_memory)
    );
    assert_eq!(
        download(&mut server, &mut objects, &long, None),
        Err(out_of_memory)
    );
    assert!(objects.0.is_empty());
    objects.0 = long.to_vec();
    assert_eq!(upload(&mut server, &mut objects), Err(out_of_memory));
}

#[test]
fn s26_the_time_out_aborts_once() {
    let mut server = Server::new();
    let mut objects = OneString(std::vec![1; 20]);
    server.receive(&Request::InitiateUpload(OBJECT).emit(), NOW, &mut objects);
    assert_eq!(server.poll(NOW + TIME_OUT - Duration::from_ticks(1)), None);
    let abort = Response::Abort {
        object: OBJECT,
        code: 0x0504_0000,
    }
    .emit();
    assert_eq!(server.poll(NOW + TIME_OUT), Some(abort));
    assert_eq!(server.poll(NOW + TIME_OUT), None);
}

/// An object whose owner takes its time.
struct Slow;

impl Objects for Slow {
    fn read(&mut self, _: Multiplexer) -> Result<&[u8], AbortCode> {
        Ok(&[1])
    }

    fn writable(&mut self, _: Multiplexer) -> Result<&'static Entry, AbortCode> {
        Ok(&STRING)
    }

    fn write(&mut self, _: &'static Entry, _: &[u8]) -> Result<Completion, AbortCode> {
        Ok(Completion::Later)
    }
}

#[test]
fn the_answer_to_a_write_may_come_later() {
    let later = NOW + TIME_OUT * 100;
    let mut server = Server::new();
    let write = Request::InitiateDownload {
        object: OBJECT,
        payload: Payload::Expedited(&[1, 2, 3, 4]),
    }
    .emit();
    let written = Response::InitiateDownload(OBJECT).emit();
    let aborted = Response::Abort {
        object: OBJECT,
        code: AbortCode::HardwareError.get(),
    }
    .emit();
    let other = Multiplexer {
        index: 0x2000,
        sub: 1,
    };
    for (result, answer) in [(Ok(()), written), (Err(AbortCode::HardwareError), aborted)] {
        assert_eq!(server.receive(&write, NOW, &mut Slow), None);
        assert_eq!(server.poll(later), None, "there is no time-out");
        assert_eq!(server.complete(other, Ok(())), None);
        assert_eq!(server.complete(OBJECT, result), Some(answer));
        assert_eq!(server.complete(OBJECT, result), None, "once");
    }
    // A client that gives up, or asks for something else, gets no answer to what it asked before.
    let abort = Request::Abort {
        object: OBJECT,
        code: 0,
    }
    .emit();
    assert_eq!(server.receive(&write, NOW, &mut Slow), None);
    assert_eq!(server.receive(&abort, NOW, &mut Slow), None);
    assert_eq!(server.complete(OBJECT, Ok(())), None);
    assert_eq!(server.receive(&write, NOW, &mut Slow), None);
    let read = Request::InitiateUpload(OBJECT).emit();
    assert!(server.receive(&read, NOW, &mut Slow).is_some());
    assert_eq!(server.complete(OBJECT, Ok(())), None);
}
