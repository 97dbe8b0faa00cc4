//! Thresholds and their hysteresis.

use proptest::prelude::*;

use super::*;

const SET: Thresholds = Thresholds {
    under_voltage: 9_000,
    under_voltage_warning: 10_000,
    over_voltage_warning: 56_000,
    over_voltage: 60_000,
    voltage_hysteresis: 500,
    temperature_warning: 800,
    over_temperature: 900,
    temperature_hysteresis: 50,
};

fn at(stage: &mut PowerStage, voltage: u32) -> (bool, bool, bool, bool) {
    let inputs = Inputs {
        supply: true,
        supply_voltage: Some(voltage),
        ..Inputs::default()
    };
    stage.observe(&inputs, &SET);
    let warnings = stage.warnings;
    (
        stage.has_supply,
        warnings.under_voltage,
        warnings.over_voltage,
        stage.over_voltage,
    )
}

#[test]
fn m13_the_supply_is_there_above_its_threshold_and_its_hysteresis() {
    let mut stage = PowerStage::new();
    for (voltage, expected) in [
        (24_000, (true, false, false, false)),
        (10_000, (true, false, false, false)),
        (9_999, (true, true, false, false)),
        (10_499, (true, true, false, false)),
        (10_500, (true, false, false, false)),
        (9_000, (true, true, false, false)),
        // Where there is none, it is not low.
        (8_999, (false, false, false, false)),
        (9_499, (false, false, false, false)),
        (9_500, (true, true, false, false)),
        (55_999, (true, false, false, false)),
        (56_000, (true, false, true, false)),
        (55_500, (true, false, true, false)),
        (60_000, (true, false, true, true)),
        (59_500, (true, false, true, true)),
        (59_499, (true, false, true, false)),
        (55_499, (true, false, false, false)),
    ] {
        assert_eq!(at(&mut stage, voltage), expected, "{voltage} mV");
    }
}

#[test]
fn m13_without_a_measurement_the_input_says_whether_there_is_a_supply() {
    let mut stage = PowerStage::new();
    for supply in [true, false, true] {
        let inputs = Inputs {
            supply,
            ..Inputs::default()
        };
        stage.observe(&inputs, &SET);
        let expected = PowerStage {
            has_supply: supply,
            ..PowerStage::new()
        };
        assert_eq!(stage, expected);
    }
}

#[test]
fn m13_an_input_without_supply_goes_before_what_is_measured() {
    let mut stage = PowerStage::new();
    let inputs = Inputs {
        supply_voltage: Some(24_000),
        ..Inputs::default()
    };
    stage.observe(&inputs, &SET);
    assert!(!stage.has_supply);
}

#[test]
fn a_threshold_of_0_is_off() {
    let mut stage = PowerStage::new();
    for voltage in [0, 24_000, u32::MAX] {
        let inputs = Inputs {
            supply: true,
            supply_voltage: Some(voltage),
            temperature: Some(3_000),
            ..Inputs::default()
        };
        let off = Thresholds {
            voltage_hysteresis: 500,
            ..Thresholds::NONE
        };
        stage.observe(&inputs, &off);
        assert!(stage.has_supply && !stage.over_voltage && !stage.over_temperature);
        assert_eq!(stage.warnings, Warnings::default());
    }
}

#[test]
fn m14_the_temperature_warns_before_it_is_a_fault() {
    let mut stage = PowerStage::new();
    for (temperature, expected) in [
        (250, (false, false)),
        (799, (false, false)),
        (800, (true, false)),
        (750, (true, false)),
        (749, (false, false)),
        (900, (true, true)),
        (850, (true, true)),
        (849, (true, false)),
        (-400, (false, false)),
    ] {
        let inputs = Inputs {
            temperature: Some(temperature),
            ..Inputs::default()
        };
        stage.observe(&inputs, &SET);
        let seen = (stage.warnings.temperature, stage.over_temperature);
        assert_eq!(seen, expected, "{temperature}");
    }
}

proptest! {
    /// A threshold changes only outside of its hysteresis, and there always.
    #[test]
    fn m13_within_the_hysteresis_nothing_changes(
        voltages in prop::collection::vec(0u32..70_000, 1..200),
    ) {
        let mut stage = PowerStage::new();
        at(&mut stage, 24_000);
        for voltage in voltages {
            let before = stage;
            at(&mut stage, voltage);
            prop_assert_eq!(!stage.under_voltage, match voltage {
                0..9_000 => false,
                9_000..9_500 => !before.under_voltage,
                _ => true,
            });
            prop_assert_eq!(stage.over_voltage, match voltage {
                0..59_500 => false,
                59_500..60_000 => before.over_voltage,
                _ => true,
            });
        }
    }
}
