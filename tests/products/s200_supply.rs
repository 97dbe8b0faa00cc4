//! What feeds the S200 and enables it: bus voltage, regeneration, mains, temperatures, the hardware enable.

use sim::plant::{Switch, Track};

use crate::bench::Bench;
use crate::steer::{NODE, command, enabled, number, on, position, statusword, way};

/// The error code of the next emergency message.
fn emergency(bench: &mut Bench) -> Option<u16> {
    let message = bench.next(0x84, 100)?;
    Some(u16::from_le_bytes([
        message.payload()[0],
        message.payload()[1],
    ]))
}

fn warnings(bench: &mut Bench) -> u32 {
    bench.read(NODE, 0x2000, 0)
}

fn display(bench: &mut Bench) -> String {
    let bytes = bench.read(NODE, 0x5104, 0).to_le_bytes();
    String::from_utf8_lossy(&bytes).trim_end().to_owned()
}

fn supply(bench: &mut Bench, volts: u32) {
    bench.drive.plant_mut().supply_voltage = volts * 1_000;
}

/// VBUSBAL is the line voltage; one and a half times as much is VBUSMAX, where the bus is too high: F02.
#[test]
fn vbusbal_sets_where_the_bus_is_too_high() {
    for (line, code) in [(200, Some(0x3110)), (230, None), (0, None)] {
        let mut bench = Bench::node("s200", NODE);
        number(&mut bench, 0x361B, 1, line);
        assert_eq!(bench.read(NODE, 0x361C, 1), line * 3 / 2, "VBUSMAX");
        bench.sent.clear();
        supply(&mut bench, 299);
        assert_eq!(emergency(&mut bench), None);
        supply(&mut bench, 305);
        assert_eq!(emergency(&mut bench), code, "{line} V");
    }
}

/// PBAL is the power of the resistor that PBALRES chooses; beyond PBALMAX is n02, and beyond one and a half times that F18.
#[test]
fn regeneration_is_watched() {
    for (resistor, power, state) in [(0, 2_637, "n02"), (1, 5_801, "F18")] {
        let mut bench = Bench::node("s200", NODE);
        number(&mut bench, 0x361B, 1, 200);
        number(&mut bench, 0x35C1, 1, 2_000);
        number(&mut bench, 0x35C2, 1, resistor);
        supply(&mut bench, 250);
        bench.run(500);
        assert_eq!(bench.read(NODE, 0x35C0, 1), 0, "it is off");
        bench.sent.clear();
        supply(&mut bench, 295);
        bench.run(500);
        assert_eq!(warnings(&mut bench) & 2 != 0, resistor == 1, "not yet");
        bench.run(6_000);
        let shown = bench.read(NODE, 0x35C0, 1);
        assert!(shown.abs_diff(power) <= power / 50, "{shown}");
        assert_eq!(warnings(&mut bench) & 2, 2, "n02");
        assert_eq!(display(&mut bench), state);
        supply(&mut bench, 250);
        bench.run(3_000);
        assert_eq!(warnings(&mut bench) & 2, 0);
    }
}

/// A phase that is missing is n05 with PMODE 1, F16 with 2, and nothing with 0.
#[test]
fn pmode_says_what_a_missing_phase_is() {
    for (mode, shown) in [(0, "D"), (1, "n05"), (2, "F16")] {
        let mut bench = Bench::node("s200", NODE);
        number(&mut bench, 0x35CD, 1, mode);
        bench.drive.plant_mut().warning = Some(0x3130);
        bench.run(50);
        assert_eq!(display(&mut bench), shown);
        assert_eq!(warnings(&mut bench) >> 4 & 1, u32::from(mode == 1));
    }
}

/// UVLTMODE 1 reports under-voltage while the motor has no power as well.
#[test]
fn uvltmode_says_when_under_voltage_is_told() {
    for (mode, off, on) in [(0, "D", "F05"), (1, "F05", "F05")] {
        let mut bench = Bench::node("s200", NODE);
        number(&mut bench, 0x361D, 1, 20);
        number(&mut bench, 0x3617, 1, mode);
        number(&mut bench, 0x35AA, 1, 1);
        supply(&mut bench, 15);
        bench.run(50);
        assert_eq!(display(&mut bench), off);
        command(&mut bench, 0x06);
        bench.run(20);
        command(&mut bench, 0x07);
        bench.run(20);
        command(&mut bench, 0x0F);
        bench.run(20);
        assert_eq!(display(&mut bench), on);
    }
}

/// NONBTB 0 checks that there is mains before the motor gets power: F16.
#[test]
fn nonbtb_says_whether_mains_is_checked() {
    for (mode, shown) in [(0, "F16"), (1, "D")] {
        let mut bench = Bench::node("s200", NODE);
        number(&mut bench, 0x35AA, 1, mode);
        bench.drive.plant_mut().supply = false;
        bench.run(50);
        assert_eq!(display(&mut bench), "D");
        command(&mut bench, 0x06);
        bench.run(50);
        assert_eq!(display(&mut bench), shown);
    }
}

/// MAXTEMPE: F13 where it is too hot around the drive.
#[test]
fn maxtempe_is_the_ambient_temperature_that_the_s200_bears() {
    let mut bench = enabled("s200", 3);
    number(&mut bench, 0x3584, 1, 60);
    bench.drive.plant_mut().temperature = 590;
    bench.run(50);
    assert_eq!(display(&mut bench), "E");
    bench.sent.clear();
    bench.drive.plant_mut().temperature = 605;
    assert_eq!(emergency(&mut bench), Some(0x4110));
    assert_eq!(display(&mut bench), "F13");
}

/// ANCNFG 8: the analogue input is the temperature of the motor, which MTemp shows and MAXTEMPM and MTempLimit bound: F06.
#[test]
fn the_temperature_of_the_motor_is_watched() {
    for (parameter, polarity, degrees) in [(0x3586, 0, 95), (0x3B71, 0, 95), (0x3B71, 1, 75)] {
        let mut bench = Bench::node("s200", NODE);
        let heat = |bench: &mut Bench, degrees: u32| {
            bench.drive.plant_mut().analogue = (degrees * 4_095).div_ceil(1_000) as u16;
            bench.run(50);
        };
        heat(&mut bench, 85);
        assert_eq!(bench.read(NODE, 0x3B40, 1), 0);
        number(&mut bench, 0x3507, 1, 8);
        bench.run(20);
        assert_eq!(bench.read(NODE, 0x3B40, 1), 85, "MTemp");
        number(&mut bench, 0x3B72, 1, polarity);
        number(
            &mut bench,
            parameter,
            1,
            if polarity == 0 { 90 } else { 80 },
        );
        bench.run(20);
        assert_eq!(display(&mut bench), "D");
        heat(&mut bench, degrees);
        assert_eq!(display(&mut bench), "F06", "{parameter:04X}h {polarity}");
    }
}

/// An axis with the hardware enable at input 5, there up to this position.
fn with_enable(end: i64) -> Bench {
    let wires = Track {
        probes: [Some(Switch::up_to(end)), None],
        ..Track::default()
    };
    let mut bench = on("s200", wires);
    bench.write(NODE, 0x5106, 0, &[5]);
    bench.run(20);
    bench
}

/// Without its hardware enable the motor has no power, whatever the controlword says; REMOTE and bit 29 of 1002h tell.
#[test]
fn the_hardware_enable_is_needed_beside_the_software_enable() {
    let mut bench = with_enable(20_000);
    let told = |bench: &mut Bench| {
        (
            bench.read(NODE, 0x35E4, 1),
            bench.read(NODE, 0x1002, 0) >> 29 & 1,
        )
    };
    assert_eq!(told(&mut bench), (1, 1));
    bench.write(NODE, 0x6060, 0, &[3]);
    bench.enable(NODE);
    number(&mut bench, 0x60FF, 0, 30_000);
    bench.run(1_500);
    assert_eq!(told(&mut bench), (0, 0));
    assert_eq!(statusword(&mut bench) & 0x4F, 0x40);
    assert!(!bench.drive.plant_mut().is_energised());
    assert!(position(&mut bench).abs_diff(20_000) < 1_000);
    for word in [0x06, 0x07, 0x0F] {
        command(&mut bench, word);
        bench.run(20);
        assert_eq!(statusword(&mut bench) & 0x4F, 0x40, "{word:02X}h");
    }
    bench.write(NODE, 0x5106, 0, &[0]);
    bench.enable(NODE);
    assert_eq!(told(&mut bench), (1, 1));
}

/// AENA that was saved enables the drive at power-up, where it has a hardware enable, until a controlword is written.
#[test]
fn aena_enables_the_s200_at_power_up() {
    for (stored, is_there, state) in [(1, true, 0x27), (0, true, 0x40), (1, false, 0x40)] {
        let mut bench = with_enable(if is_there { 100_000 } else { -10 });
        number(&mut bench, 0x3506, 1, stored);
        number(&mut bench, 0x35B4, 1, 0);
        number(&mut bench, 0x1010, 1, 0x6576_6173);
        assert_eq!(statusword(&mut bench) & 0x6F, 0x40, "not before power-up");
        bench.drive.power_cycle();
        bench.run(500);
        assert_eq!(
            statusword(&mut bench) & 0x4F & state,
            state & 0x4F,
            "{stored} {is_there}"
        );
        assert_eq!(bench.drive.plant_mut().is_energised(), state == 0x27);
        if state == 0x27 {
            number(&mut bench, 0x60FF, 0, 30_000);
            assert!(way(&mut bench, 500) > 5_000);
            command(&mut bench, 0);
            bench.run(100);
            assert!(!bench.drive.plant_mut().is_energised());
        }
    }
}
