use std::vec::Vec;

use super::{Beat, Sync};
use crate::cia301::error_report::ErrorReport;
use crate::cia301::pdo::tests::objects::Objects;
use crate::cia301::sdo::AbortCode;
use crate::od::{Dictionary, write_u32};
use crate::time::Instant;

const NOW: Instant = Instant::from_ticks(1_000);

/// A SYNC without a counter.
const BEAT: Option<Beat> = Some(Beat { counter: None });

fn validate(sync: &Sync, value: &[u8]) -> Result<(), AbortCode> {
    let entry = Objects::TABLE.find(super::COB_ID, 0).unwrap();
    sync.validate(&Objects::new(), entry, value)
}

fn consumer(cob_id: u32) -> Sync {
    let mut objects = Objects::new();
    assert!(write_u32(&mut objects, super::COB_ID, 0, cob_id));
    let mut sync = Sync::new();
    sync.configure(&objects, NOW);
    sync.enter(true, NOW);
    sync
}

/// The emergency error codes that appeared (true) and went.
fn reports(sync: &mut Sync) -> Vec<(u16, bool)> {
    core::iter::from_fn(|| sync.report())
        .map(|report| match report {
            ErrorReport::Appeared(emergency) => {
                assert_eq!(emergency.register, 0x10);
                (emergency.code, true)
            }
            ErrorReport::Gone(emergency) => (emergency.code, false),
        })
        .collect()
}

#[test]
fn the_identifier_follows_1005h() {
    assert_eq!(Sync::new().cob_id(), 0);
    assert_eq!(consumer(0x80).cob_id(), 0x80);
    assert_eq!(
        consumer(0x8000_0080).cob_id(),
        0x80,
        "bit 31 does not matter"
    );
    let mut sync = consumer(0x80);
    let mut objects = Objects::new();
    write_u32(&mut objects, super::COB_ID, 0, 0x90);
    sync.written(&objects, NOW);
    assert_eq!(sync.cob_id(), 0x90);
}

#[test]
fn a_power_on_value_that_is_not_supported_hears_nothing() {
    assert_eq!(consumer(0x2000_0080).cob_id(), 0);
}

#[test]
fn y06_a_sync_with_data_is_ignored_and_reported_once() {
    let mut sync = consumer(0x80);
    assert_eq!(sync.receive(0, 0, NOW), BEAT);
    assert_eq!(reports(&mut sync), []);
    assert_eq!(sync.receive(1, 1, NOW), None);
    assert_eq!(reports(&mut sync), [(0x8240, true)]);
    assert_eq!(sync.receive(8, 1, NOW), None);
    assert_eq!(reports(&mut sync), []);
    assert_eq!(sync.receive(0, 0, NOW), BEAT);
    assert_eq!(reports(&mut sync), [(0x8240, false)]);
    assert_eq!(sync.receive(0, 0, NOW), BEAT);
    assert_eq!(reports(&mut sync), []);
}

#[test]
fn y06_a_reset_ends_the_error() {
    let mut sync = consumer(0x80);
    sync.receive(1, 1, NOW);
    assert_eq!(reports(&mut sync), [(0x8240, true)]);
    sync.configure(&Objects::new(), NOW);
    assert_eq!(reports(&mut sync), [(0x8240, false)]);
}

#[test]
fn s41_a_restricted_identifier_is_refused() {
    let sync = consumer(0x80);
    for cob_id in [
        0x000_u32,
        0x07F,
        0x101,
        0x180,
        0x581,
        0x601,
        0x6E0,
        0x701,
        0x7FF,
        0x8000_0000,
        0x4000_0000,
    ] {
        assert_eq!(
            validate(&sync, &cob_id.to_le_bytes()),
            Err(AbortCode::InvalidValue),
            "{cob_id:X}h"
        );
    }
    for cob_id in [0x80_u32, 0x8000_0080, 0x4000_0080, 0x100, 0x181] {
        assert_eq!(
            validate(&sync, &cob_id.to_le_bytes()),
            Ok(()),
            "{cob_id:X}h"
        );
    }
}

#[test]
fn y05_29_bit_identifiers_are_refused() {
    let sync = consumer(0x80);
    for cob_id in [0x2000_0080_u32, 0x6000_0080, 0x0001_0080, 0x0000_0880] {
        assert_eq!(
            validate(&sync, &cob_id.to_le_bytes()),
            Err(AbortCode::InvalidValue),
            "{cob_id:X}h"
        );
    }
    assert_eq!(validate(&sync, &[0x80, 0]), Err(AbortCode::LengthMismatch));
}
