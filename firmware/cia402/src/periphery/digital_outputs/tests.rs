//! Who sets an output, and when.

use proptest::prelude::*;

use super::*;
use crate::outputs::COUNT;

const QUIET: Shown = Shown {
    state: State::SwitchOnDisabled,
    statusword: 0,
    referenced: false,
    moving: false,
    brake_released: false,
};

fn written(outputs: u32, mask: u32) -> Commands {
    Commands {
        remote: true,
        digital_outputs: outputs,
        digital_outputs_mask: mask,
        outputs_written: true,
        ..Commands::NONE
    }
}

const MANUAL: OutputConfiguration = OutputConfiguration::NONE;

fn levels(outputs: &DigitalOutputs) -> u8 {
    outputs.levels(&QUIET, &MANUAL)
}

#[test]
fn m71_only_outputs_in_the_mask_change() {
    let mut outputs = DigitalOutputs::new();
    outputs.command(&written(0x000F_0000, 0), &MANUAL);
    assert_eq!(levels(&outputs), 0);
    outputs.command(&written(0x000F_0000, 0x0005_0000), &MANUAL);
    assert_eq!(levels(&outputs), 0b0101);
    outputs.command(&written(0, 0x0001_0000), &MANUAL);
    assert_eq!(levels(&outputs), 0b0100, "what left the mask stays");
}

proptest! {
    #[test]
    fn m71_an_output_is_what_was_last_written_with_its_mask(
        writes in prop::collection::vec((any::<u32>(), any::<u32>()), 1..50),
    ) {
        let mut outputs = DigitalOutputs::new();
        let mut expected = 0;
        for (value, mask) in writes {
            outputs.command(&written(value, mask), &MANUAL);
            for bit in (16..20).filter(|bit| mask & 1 << bit != 0) {
                expected = expected & !(1 << bit) | value & 1 << bit;
            }
            prop_assert_eq!(u32::from(levels(&outputs)) << 16, expected);
        }
    }
}

#[test]
fn outputs_go_to_rest_with_the_network_and_stay_there_until_they_are_written() {
    let mut outputs = DigitalOutputs::new();
    let configuration = OutputConfiguration {
        kept: 0b0100,
        ..MANUAL
    };
    let all = written(0x000F_0000, 0x000F_0000);
    outputs.command(&all, &configuration);
    assert_eq!(levels(&outputs), 0b1111);
    let lost = Commands {
        remote: false,
        outputs_written: false,
        ..all
    };
    outputs.command(&lost, &configuration);
    assert_eq!(levels(&outputs), 0b0100, "2062h keeps one");
    let back = Commands {
        outputs_written: false,
        ..all
    };
    outputs.command(&back, &configuration);
    assert_eq!(levels(&outputs), 0b0100);
    outputs.command(&all, &configuration);
    assert_eq!(levels(&outputs), 0b1111);
}

#[test]
fn what_was_stored_does_not_come_by_itself() {
    let mut outputs = DigitalOutputs::new();
    let stored = Commands {
        outputs_written: false,
        ..written(0x000F_0000, 0x000F_0000)
    };
    outputs.command(&stored, &MANUAL);
    assert_eq!(levels(&outputs), 0);
}

#[test]
fn each_function_shows_what_it_says() {
    use OutputFunction as F;
    let with = |statusword| Shown {
        statusword,
        ..QUIET
    };
    let cases = [
        (
            F::Fault,
            Shown {
                state: State::Fault,
                ..QUIET
            },
        ),
        (
            F::Fault,
            Shown {
                state: State::FaultReactionActive,
                ..QUIET
            },
        ),
        (F::Warning, with(statusword::WARNING)),
        (
            F::OperationEnabled,
            Shown {
                state: State::OperationEnabled,
                ..QUIET
            },
        ),
        (F::TargetReached, with(statusword::TARGET_REACHED)),
        (
            F::Referenced,
            Shown {
                referenced: true,
                ..QUIET
            },
        ),
        (
            F::Moving,
            Shown {
                moving: true,
                ..QUIET
            },
        ),
        (F::Limit, with(statusword::INTERNAL_LIMIT)),
        (
            F::BrakeReleased,
            Shown {
                brake_released: true,
                ..QUIET
            },
        ),
    ];
    for (function, shown) in cases {
        let configuration = OutputConfiguration {
            functions: [F::Manual, function, F::Manual, F::Manual],
            ..MANUAL
        };
        let mut outputs = DigitalOutputs::new();
        // What the master sets of an output with a function is of no account.
        outputs.command(&written(0x0003_0000, 0x000F_0000), &configuration);
        assert_eq!(
            outputs.levels(&shown, &configuration),
            0b0011,
            "{function:?}"
        );
        assert_eq!(
            outputs.levels(&QUIET, &configuration),
            0b0001,
            "{function:?}"
        );
        let others = F::ALL
            .into_iter()
            .filter(|other| *other != function && *other != F::Manual);
        for other in others {
            let configuration = OutputConfiguration {
                functions: [other; COUNT],
                ..MANUAL
            };
            assert_eq!(
                outputs.levels(&shown, &configuration),
                0,
                "{other:?}, {function:?}"
            );
        }
    }
}

#[test]
fn functions_have_the_numbers_of_2060h() {
    for (number, function) in (0..).zip(OutputFunction::ALL) {
        assert_eq!(OutputFunction::from_code(number), Some(function));
    }
    assert_eq!(OutputFunction::from_code(9), None);
}

#[test]
fn an_inverted_output_is_low_where_it_would_be_high() {
    let inverted = OutputConfiguration {
        inverted: 0b1010,
        ..MANUAL
    };
    let mut outputs = DigitalOutputs::new();
    outputs.command(&written(0x0003_0000, 0x000F_0000), &inverted);
    assert_eq!(outputs.levels(&QUIET, &inverted), 0b1001);
}

#[test]
fn m71_the_brake_is_the_state_machines_unless_2063h_says_otherwise() {
    let manual = OutputConfiguration {
        is_brake_manual: true,
        ..MANUAL
    };
    for (configuration, commands, brake) in [
        (MANUAL, written(1, 1), None),
        (manual, written(1, 1), Some(false)),
        (manual, written(0, 1), Some(true)),
        (manual, written(0, 0xFFFF_FFFE), None),
        (
            manual,
            Commands {
                remote: false,
                ..written(0, 1)
            },
            None,
        ),
        (
            manual,
            Commands {
                outputs_written: false,
                ..written(0, 1)
            },
            None,
        ),
    ] {
        let mut outputs = DigitalOutputs::new();
        outputs.command(&commands, &configuration);
        assert_eq!(outputs.brake(), brake, "{commands:?}");
    }
}
