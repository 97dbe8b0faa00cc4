"""The image of the servo board `odrive36`, with a gate driver and a motor on its pins."""

import pytest
from drive import FAULT, FAULT_RESET, OPERATION_ENABLED
from gate_driver import CONTROL_1, CONTROL_2, GateDriver
from motor import Motor
from servo_bench import (
    PERIOD, PROFILE_POSITION, Kind, commanded, enable, hold, in_flash, interrupts_are_short, measure, move, on_the_way, starting,
)  # fmt: skip
from stm32f405 import HZ
from stm32f405.image import Image
from tuner import is_within_bounds

#: The rated torque of the motor, in mN·m, behind its current in mA.
RATED = 320
RATINGS = (4_000, RATED)


def begin(start, **how):
    """A chip with a gate driver and a motor."""
    bench = start(**how)
    chip = bench.chip
    chip.gates = GateDriver(chip.spi[3], "PC13", "PB12", "PD2")
    # 25 °C at the thermistor.
    chip.adc.levels[15] = 1_015
    chip.pins.drive("PC9", 0)
    chip.motor = Motor(chip)
    return bench


@pytest.fixture(scope="module")
def kind(pytestconfig):
    return Kind(Image(pytestconfig.getoption("--servo-image")), begin, RATINGS)


@pytest.fixture(scope="module")
def booted_servo(kind):
    return kind.booted()


@pytest.fixture(scope="module")
def found_servo(kind, booted_servo):
    return kind.found(booted_servo)


@pytest.fixture
def starts(kind, monkeypatch):
    yield from starting(kind.image, monkeypatch)


@pytest.fixture
def servo(starts, booted_servo):
    return commanded(starts.like(booted_servo))


@pytest.fixture
def found(starts, found_servo):
    return commanded(starts.like(found_servo))


def test_the_gate_driver_is_set_up_and_no_switch_is_on_before(servo):
    chip = servo.chip
    assert chip.gates.registers == {CONTROL_1: 0x550, CONTROL_2: 0x00C}
    assert servo[0x6041] & 0x10, "the supply is there"
    assert chip.motor.most == 0.0 and chip.tim1.centre.duties() is None
    assert abs(servo[0x6079] - 48_000) < 50


def test_a_torque_is_held_and_a_bus_that_rises_is_burnt(found):
    servo, chip, motor = found, found.chip, found.chip.motor
    hold(servo, 500)
    torque = motor.torque() * 1e3
    assert abs(torque - RATED / 2) < 0.02 * RATED / 2, torque
    assert abs(motor.d) < 0.05
    assert abs(servo[0x6077] - 500) <= 5

    assert chip.tim2.burns() == 0
    motor.bus = 49.9
    servo.bench.milliseconds(2)
    assert 0.3 < chip.tim2.burns() < 0.7
    motor.bus = 48.0
    servo.bench.milliseconds(2)
    assert chip.tim2.burns() == 0
    motor.bus = 61.0
    servo.until(lambda: servo.state() == FAULT, "fault")
    assert servo[0x603F] == 0x3210
    assert chip.tim1.centre.duties() is None


def test_a_position_is_reached_and_a_fault_of_the_gate_driver_takes_the_current_at_once(found):
    servo, chip, motor = found, found.chip, found.chip.motor
    servo[0x6081], servo[0x6083], servo[0x6084] = 100_000, 2_000_000, 2_000_000
    target = move(servo, 5_000)
    servo.bench.milliseconds(200)
    assert abs(servo[0x6064] - target) <= 2
    assert abs(motor.count - target) <= 2
    assert motor.most < 12.5
    # The upper switch of phase A carries too much.
    chip.gates.show(1 << 5)
    chip.run(HZ // 200_000)
    assert chip.tim1.centre.duties() is None, "5 us later"
    servo.until(lambda: servo.state() == FAULT, "fault")
    assert servo[0x603F] == 0x2310
    # What has latched is cleared for a master that wants to go on.
    chip.gates.show(0)
    servo.bench.milliseconds(300)
    servo[0x6040] = FAULT_RESET
    servo.bench.milliseconds(50)
    enable(servo, PROFILE_POSITION)
    servo.bench.milliseconds(30)
    assert servo.state() == OPERATION_ENABLED
    assert abs(motor.count - target) <= 2


def test_counts_that_are_lost_are_a_fault_at_the_next_index(found):
    servo, chip, motor = found, found.chip, found.chip.motor
    servo[0x6081], servo[0x6083], servo[0x6084] = 100_000, 4_000_000, 4_000_000
    # Two counts wide: whole turns later and from the other side it comes where it may.
    motor.index = range(motor.count + 1_000, motor.count + 1_002)
    for way in (12_000, -12_000):
        target = move(servo, way)
        servo.bench.milliseconds(180)
        assert abs(servo[0x6064] - target) <= 2 and servo.state() == OPERATION_ENABLED
    # Five are lost.
    motor.index = range(motor.index.start - 5, motor.index.stop - 5)
    move(servo, 12_000)
    servo.until(lambda: servo.state() == FAULT, "fault")
    assert servo[0x603F] == 0x7305
    assert chip.tim1.centre.duties() is None


# Two and a half seconds of the motor.
@pytest.mark.timeout(900)
def test_the_motor_is_measured_and_the_parts_begin_within_a_period(found):
    motor = found.chip.motor
    measured, longest = measure(found)
    is_within_bounds(measured, motor, RATED * 1e-3)
    # Where the strokes begin it is still more than half a period: docs/servo.md.
    assert len(longest) == 3 and max(longest) < 5_000 < PERIOD, longest


def test_the_interrupts_are_short(found):
    hold(found, 300)
    interrupts_are_short(found.chip, 20)


def test_they_are_in_a_move_too(found):
    on_the_way(found, 100_000, 100_000)
    interrupts_are_short(found.chip, 20)


def test_what_the_current_interrupt_does_in_each_period_runs_in_ram(found):
    hold(found, 300)
    assert not set.intersection(*in_flash(found.chip, 10))
