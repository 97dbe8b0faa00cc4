//! What a master may write into the PDO parameters.

use super::device::{Device, mapped};
use crate::cia301::sdo::AbortCode;

const U8: u32 = mapped(0x2000, 0, 8);
const U16: u32 = mapped(0x2001, 0, 16);
const U32: u32 = mapped(0x2002, 0, 32);
const U64: u32 = mapped(0x2003, 0, 64);

/// Both directions: first communication record, first mapping record, identifier of the first PDO.
const DIRECTIONS: [(u16, u16, u32); 2] = [(0x1400, 0x1600, 0x204), (0x1800, 0x1A00, 0x184)];

#[test]
fn p01_a_mapping_entry_is_refused_while_entries_are_counted() {
    for (communication, mapping, _) in DIRECTIONS {
        let mut device = Device::new();
        device.map(communication, 0, 255, &[U8]).unwrap();
        device.write_u32(communication, 1, 0x8000_0204).unwrap();
        assert_eq!(
            device.write_u32(mapping, 1, U16),
            Err(AbortCode::UnsupportedAccess)
        );
        assert_eq!(device.bytes(mapping, 1), U8.to_le_bytes());
    }
}

#[test]
fn p02_the_count_is_refused_while_the_pdo_is_valid() {
    for (communication, mapping, _) in DIRECTIONS {
        let mut device = Device::new();
        device.map(communication, 0, 255, &[U8]).unwrap();
        assert_eq!(
            device.write_u8(mapping, 0, 0),
            Err(AbortCode::UnsupportedAccess)
        );
        assert_eq!(
            device.write_u32(mapping, 1, U8),
            Err(AbortCode::UnsupportedAccess)
        );
    }
}

#[test]
fn p03_the_procedure_is_accepted_step_by_step() {
    for (communication, mapping, identifier) in DIRECTIONS {
        let mut device = Device::new();
        assert_eq!(
            device.write_u32(communication, 1, 0x8000_0000 | identifier),
            Ok(())
        );
        assert_eq!(device.write_u8(mapping, 0, 0), Ok(()));
        assert_eq!(device.write_u32(mapping, 1, U16), Ok(()));
        assert_eq!(device.write_u32(mapping, 2, U32), Ok(()));
        assert_eq!(device.write_u8(mapping, 0, 2), Ok(()));
        assert_eq!(device.write_u32(communication, 1, identifier), Ok(()));
    }
}

#[test]
fn p04_more_entries_than_the_record_has_are_refused() {
    for (_, mapping, _) in DIRECTIONS {
        let mut device = Device::new();
        for count in [9, 64, 65, 253] {
            assert_eq!(
                device.write_u8(mapping, 0, count),
                Err(AbortCode::PdoLengthExceeded)
            );
        }
    }
}

#[test]
fn p05_more_than_64_bits_are_refused() {
    for (_, mapping, _) in DIRECTIONS {
        let mut device = Device::new();
        device.write_u32(mapping, 1, U64).unwrap();
        device.write_u32(mapping, 2, U8).unwrap();
        assert_eq!(
            device.write_u8(mapping, 0, 2),
            Err(AbortCode::PdoLengthExceeded)
        );
        assert_eq!(device.write_u8(mapping, 0, 1), Ok(()));
    }
}

#[test]
fn p06_a_missing_object_is_refused() {
    for (_, mapping, _) in DIRECTIONS {
        let mut device = Device::new();
        assert_eq!(
            device.write_u32(mapping, 1, mapped(0x5FFF, 0, 8)),
            Err(AbortCode::NoObject)
        );
        assert_eq!(
            device.write_u32(mapping, 1, mapped(0x200C, 9, 8)),
            Err(AbortCode::NoSubIndex)
        );
    }
}

#[test]
fn p07_the_access_of_an_object_decides_the_direction() {
    let mut device = Device::new();
    let (read_only, write_only) = (mapped(0x2005, 0, 8), mapped(0x2006, 0, 8));
    assert_eq!(
        device.write_u32(0x1600, 1, read_only),
        Err(AbortCode::NotMappable)
    );
    assert_eq!(
        device.write_u32(0x1A00, 1, write_only),
        Err(AbortCode::NotMappable)
    );
    assert_eq!(device.write_u32(0x1600, 1, write_only), Ok(()));
    assert_eq!(device.write_u32(0x1A00, 1, read_only), Ok(()));
}

#[test]
fn p07_communication_objects_are_never_received() {
    let mut device = Device::new();
    assert_eq!(
        device.write_u32(0x1600, 1, mapped(0x1005, 0, 32)),
        Err(AbortCode::NotMappable)
    );
    assert_eq!(device.write_u32(0x1A00, 1, mapped(0x1005, 0, 32)), Ok(()));
}

#[test]
fn p08_an_object_that_may_not_be_mapped_is_refused() {
    for (_, mapping, _) in DIRECTIONS {
        let mut device = Device::new();
        assert_eq!(
            device.write_u32(mapping, 1, mapped(0x2004, 0, 8)),
            Err(AbortCode::NotMappable)
        );
        assert_eq!(
            device.write_u32(mapping, 1, mapped(0x2008, 0, 64)),
            Err(AbortCode::NotMappable)
        );
    }
}

#[test]
fn p09_a_length_that_is_another_types_is_refused() {
    let (u8_, u16_, signed, boolean) = (0x2000, 0x2001, 0x200A, 0x2009);
    for (_, mapping, _) in DIRECTIONS {
        let mut device = Device::new();
        for (index, lengths) in [
            (u8_, &[0_u8, 9, 16, 255][..]),
            (u16_, &[0, 8, 17, 24, 32]),
            (signed, &[0, 1, 8, 15, 17, 32]),
            (boolean, &[0, 2, 7, 9, 16]),
        ] {
            for bits in lengths {
                assert_eq!(
                    device.write_u32(mapping, 1, mapped(index, 0, *bits)),
                    Err(AbortCode::NotMappable),
                    "{bits} bits of {index:04X}h"
                );
            }
        }
    }
}

#[test]
fn p09_low_bits_of_an_unsigned_number_may_be_mapped() {
    for (_, mapping, _) in DIRECTIONS {
        let mut device = Device::new();
        for (index, lengths) in [
            (0x2000, &[1_u8, 7, 8][..]),
            (0x2001, &[1, 9, 15, 16]),
            (0x2003, &[63, 64]),
            (0x2009, &[1, 8]),
        ] {
            for bits in lengths {
                assert_eq!(
                    device.write_u32(mapping, 1, mapped(index, 0, *bits)),
                    Ok(())
                );
            }
        }
    }
}

#[test]
fn p10_dummies_of_every_number_are_accepted_to_receive() {
    let mut device = Device::new();
    let dummies = [
        (1, 1),
        (1, 8),
        (2, 8),
        (3, 16),
        (4, 32),
        (5, 8),
        (6, 16),
        (7, 32),
        (8, 32),
        (0x10, 24),
        (0x11, 64),
        (0x12, 40),
        (0x13, 48),
        (0x14, 56),
        (0x15, 64),
        (0x16, 24),
        (0x18, 40),
        (0x19, 48),
        (0x1A, 56),
        (0x1B, 64),
    ];
    for (index, bits) in dummies {
        assert_eq!(
            device.write_u32(0x1600, 1, mapped(index, 0, bits)),
            Ok(()),
            "{index:04X}h"
        );
        assert_eq!(
            device.write_u32(0x1600, 1, mapped(index, 1, bits)),
            Err(AbortCode::NotMappable)
        );
        assert_eq!(
            device.write_u32(0x1600, 1, mapped(index, 0, bits - 1)),
            Err(AbortCode::NotMappable)
        );
    }
    for no_number in [0, 9, 0x0C, 0x0F, 0x17, 0x1C] {
        assert_eq!(
            device.write_u32(0x1600, 1, mapped(no_number, 0, 8)),
            Err(AbortCode::NoObject)
        );
    }
}

#[test]
fn p11_a_dummy_is_refused_to_transmit() {
    let mut device = Device::new();
    assert_eq!(
        device.write_u32(0x1A00, 1, mapped(2, 0, 8)),
        Err(AbortCode::NotMappable)
    );
}

#[test]
fn p12_a_pdo_that_maps_nothing_may_be_valid_and_is_inert() {
    for (communication, ..) in DIRECTIONS {
        let mut device = Device::new();
        assert_eq!(device.map(communication, 0, 255, &[]), Ok(()));
        device.enter_operational();
        assert_eq!(device.writes(0x204, &[1]), 0);
        assert_eq!(device.reports(), []);
        assert_eq!(device.after(100), []);
    }
}

#[test]
fn p13_the_identifier_of_a_valid_pdo_stays() {
    for (communication, _, identifier) in DIRECTIONS {
        let mut device = Device::new();
        device.map(communication, 0, 255, &[U8]).unwrap();
        assert_eq!(
            device.write_u32(communication, 1, identifier + 7),
            Err(AbortCode::InvalidValue)
        );
        assert_eq!(device.write_u32(communication, 1, identifier), Ok(()));
        assert_eq!(
            device.write_u32(communication, 1, 0x8000_0000 | (identifier + 7)),
            Ok(())
        );
        assert_eq!(device.write_u32(communication, 1, identifier + 7), Ok(()));
    }
}

#[test]
fn p14_a_transmit_pdo_may_allow_rtr_or_not() {
    let mut device = Device::new();
    device.map(0x1800, 0, 255, &[U8]).unwrap();
    assert_eq!(device.write_u32(0x1800, 1, 0x4000_0184), Ok(()));
    assert_eq!(device.bytes(0x1800, 1), 0x4000_0184_u32.to_le_bytes());
    assert_eq!(device.write_u32(0x1800, 1, 0x184), Ok(()));
}

#[test]
fn p15_a_29_bit_identifier_is_refused() {
    for (communication, _, identifier) in DIRECTIONS {
        let mut device = Device::new();
        assert_eq!(
            device.write_u32(communication, 1, 0x2000_0000 | identifier),
            Err(AbortCode::InvalidValue)
        );
        assert_eq!(
            device.write_u32(communication, 1, 0xA000_0000 | identifier),
            Err(AbortCode::InvalidValue)
        );
        assert_eq!(
            device.write_u32(communication, 1, 0x0001_0000 | identifier),
            Err(AbortCode::InvalidValue)
        );
    }
}

#[test]
fn s41_a_restricted_identifier_is_refused() {
    for (communication, ..) in DIRECTIONS {
        let mut device = Device::new();
        for identifier in [
            0x000, 0x07F, 0x101, 0x180, 0x581, 0x5FF, 0x601, 0x67F, 0x6E0, 0x6FF, 0x701, 0x7FF,
        ] {
            assert_eq!(
                device.write_u32(communication, 1, identifier),
                Err(AbortCode::InvalidValue),
                "{identifier:X}h"
            );
        }
        assert_eq!(
            device.write_u32(communication, 1, 0x8000_0000),
            Ok(()),
            "not valid, so it takes nobody's identifier"
        );
    }
}

#[test]
fn p16_the_inhibit_time_of_a_valid_pdo_stays() {
    let mut device = Device::new();
    assert_eq!(device.write_u16(0x1800, 3, 100), Ok(()));
    device.map(0x1800, 0, 255, &[U8]).unwrap();
    assert_eq!(
        device.write_u16(0x1800, 3, 200),
        Err(AbortCode::InvalidValue)
    );
    assert_eq!(device.write_u16(0x1800, 3, 100), Ok(()), "no change");
    assert_eq!(device.bytes(0x1800, 3), 100_u16.to_le_bytes());
}

#[test]
fn p17_the_sync_start_value_of_a_valid_pdo_stays() {
    let mut device = Device::new();
    assert_eq!(device.write_u8(0x1800, 6, 5), Ok(()));
    assert_eq!(device.write_u8(0x1800, 6, 240), Ok(()));
    assert_eq!(
        device.write_u8(0x1800, 6, 241),
        Err(AbortCode::InvalidValue)
    );
    device.map(0x1800, 0, 255, &[U8]).unwrap();
    for start in [0, 5, 240] {
        assert_eq!(
            device.write_u8(0x1800, 6, start),
            Err(AbortCode::InvalidValue)
        );
    }
    assert_eq!(device.bytes(0x1800, 6), [240]);
}

#[test]
fn p18_transmission_types_are_those_of_the_direction() {
    for (communication, ..) in DIRECTIONS {
        let mut device = Device::new();
        for number in 0..=255 {
            let expected = match number {
                0..=240 | 254 | 255 => Ok(()),
                252 | 253 if communication == 0x1800 => Ok(()),
                _ => Err(AbortCode::InvalidValue),
            };
            assert_eq!(
                device.write_u8(communication, 2, number),
                expected,
                "type {number}"
            );
        }
    }
}

#[test]
fn an_empty_entry_may_be_written_but_not_counted() {
    for (_, mapping, _) in DIRECTIONS {
        let mut device = Device::new();
        assert_eq!(device.write_u32(mapping, 1, U8), Ok(()));
        assert_eq!(device.write_u32(mapping, 2, 0), Ok(()));
        assert_eq!(device.write_u8(mapping, 0, 2), Err(AbortCode::NotMappable));
        assert_eq!(device.write_u8(mapping, 0, 1), Ok(()));
    }
}

#[test]
fn a_mapping_that_cannot_be_resolved_is_not_made_valid() {
    let mut device = Device::new();
    crate::od::write_u32(&mut device.objects, 0x1600, 1, mapped(0x5FFF, 0, 8));
    crate::od::write_u8(&mut device.objects, 0x1600, 0, 1);
    assert_eq!(device.write_u32(0x1400, 1, 0x204), Err(AbortCode::NoObject));
}

#[test]
fn a_refused_write_changes_nothing() {
    let mut device = Device::new();
    device.map(0x1400, 0, 255, &[U8]).unwrap();
    device.enter_operational();
    let before = device.objects.clone();
    assert!(device.write_u8(0x1600, 0, 0).is_err());
    assert!(device.write_u32(0x1400, 1, 0x20B).is_err());
    assert!(device.write_u8(0x1400, 2, 251).is_err());
    assert_eq!(
        crate::od::Dictionary::ram(&before),
        crate::od::Dictionary::ram(&device.objects)
    );
    assert_eq!(device.writes(0x204, &[9]), 1);
    assert_eq!(device.u8(0x2000), 9);
}
