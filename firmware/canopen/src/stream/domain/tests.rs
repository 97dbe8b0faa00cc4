use std::vec;
use std::vec::Vec;

use super::{Domain, Sink, Source};
use crate::cia301::sdo::{AbortCode, Completion};
use crate::od::{Count, Dictionary, Table};

/// A DOMAIN has nothing in the dictionary.
struct Empty;

impl Dictionary for Empty {
    type Counts = Count<0, 0, 1, 0>;
    const TABLE: &'static Table = &Table {
        entries: &[],
        buckets: &[],
        rom: &[],
        defaults: &[],
        limits: &[],
        storage: Table::NO_STORAGE,
    };
    fn ram(&self) -> &[u8] {
        &[]
    }
    fn ram_mut(&mut self) -> &mut [u8] {
        &mut []
    }
}

fn domain() -> Domain<Vec<u8>> {
    Domain::new(vec![0xEE; 10], vec![0xEE; 12])
}

/// Writes in pieces of seven bytes.
fn write(domain: &mut Domain<Vec<u8>>, value: &[u8]) -> Result<Completion, AbortCode> {
    domain.begin(&Empty, None)?;
    for (number, piece) in (0..).zip(value.chunks(7)) {
        domain.write_at(&Empty, number * 7, piece)?;
    }
    domain.end(&mut Empty, value.len() as u32)
}

fn read(domain: &mut Domain<Vec<u8>>, position: u32, room: usize) -> Vec<u8> {
    let mut into = vec![0; room];
    let length = domain.read_at(&Empty, position, &mut into).unwrap();
    into.truncate(length);
    into
}

#[test]
fn it_is_empty_at_first_and_then_what_was_written() {
    let mut domain = domain();
    assert_eq!(domain.size(&Empty), Ok(Some(0)));
    assert_eq!(read(&mut domain, 0, 7), b"");
    for value in [&b"ten bytes!"[..], b"short", b"", b"long again"] {
        assert_eq!(write(&mut domain, value), Ok(Completion::Now));
        assert_eq!(domain.value(), value);
        assert_eq!(domain.size(&Empty), Ok(Some(value.len() as u32)));
        assert_eq!(read(&mut domain, 0, 100), value);
        assert_eq!(read(&mut domain, 3, 2), value.get(3..5).unwrap_or_default());
        assert_eq!(read(&mut domain, u32::MAX, 2), b"");
    }
}

#[test]
fn what_does_not_fit_is_refused_and_the_old_value_stays() {
    let mut domain = domain();
    write(&mut domain, b"old").unwrap();
    // As much as the smaller buffer holds, whichever is the spare one.
    for _ in 0..2 {
        assert_eq!(domain.capacity(), 10);
        assert_eq!(domain.begin(&Empty, Some(10)), Ok(()));
        assert_eq!(
            domain.begin(&Empty, Some(11)),
            Err(AbortCode::LengthTooHigh)
        );
        assert_eq!(
            domain.begin(&Empty, Some(u32::MAX)),
            Err(AbortCode::LengthTooHigh)
        );
        // The size is not told.
        assert_eq!(
            write(&mut domain, b"eleven byte"),
            Err(AbortCode::LengthTooHigh)
        );
        assert_eq!(
            domain.write_at(&Empty, u32::MAX, b"x"),
            Err(AbortCode::LengthTooHigh)
        );
        assert_eq!(domain.value(), b"old");
        write(&mut domain, b"old").unwrap();
    }
}

#[test]
fn a_write_that_does_not_end_changes_nothing() {
    let mut domain = domain();
    write(&mut domain, b"old").unwrap();
    domain.begin(&Empty, Some(9)).unwrap();
    domain.write_at(&Empty, 0, b"new val").unwrap();
    Sink::<Empty>::abandon(&mut domain, &Empty);
    assert_eq!(domain.value(), b"old");
}
