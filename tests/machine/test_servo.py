"""The image of the servo board `odrive36`, with a gate driver and a motor on its pins."""

import configparser
import functools
import io

import canopen
import pytest
from canopen.profiles.p402 import BaseNode402
from conftest import NODE_ID, ROOT, Starts, once
from drive import ENABLE, FAULT, FAULT_RESET, OPERATION_ENABLED, SHUTDOWN, SWITCH_ON, Drive
from gate_driver import CONTROL_1, CONTROL_2, GateDriver
from measure import level
from motor import Motor
from stm32f405 import HZ
from stm32f405.image import Image
from stm32f405.interrupts import IRQ

PROFILE_TORQUE, PROFILE_POSITION = 4, 1
#: Clocks of a period of the modulation.
PERIOD = 8_400
#: The rated torque of the motor, in mN·m.
RATED = 320


@functools.cache
def data_sheet():
    """That of the drive with a servo, as `eds/servo.toml` has it."""
    sheet = configparser.RawConfigParser(strict=False)
    sheet.optionxform = str
    sheet.read([ROOT / "eds" / "axis402.eds", ROOT / "eds" / "parts" / "torque.eds"], encoding="utf-8")
    text = io.StringIO()
    sheet.write(text)
    text.seek(0)
    text.name = "servo.eds"
    return canopen.import_od(text, NODE_ID)


@pytest.fixture(scope="module")
def servo_image(pytestconfig):
    return Image(pytestconfig.getoption("--servo-image"))


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
def servo_flash(servo_image):
    def number(start):
        bench = begin(start)
        bench.milliseconds(150)
        bench.give_node_id(NODE_ID, store=True)
        bench.chip.cycle_power()
        bench.chip.leave()
        return bench.chip.parameters

    return once(servo_image, number)


def commanded(bench):
    """A master's drive on it."""
    node = BaseNode402(NODE_ID, data_sheet())
    bench.network.add_node(node)
    return Drive(bench, node)


@pytest.fixture(scope="module")
def booted_servo(servo_image, servo_flash):
    """The bench of a chip that has its node-ID, with the stage ready, from which tests begin."""

    def boot(start):
        bench = begin(start, flash=servo_flash)
        bench.chip.run(20_000_000, lambda: bench.frames)
        bench.milliseconds(60)
        drive = commanded(bench)
        drive[0x6075], drive[0x6076] = 4_000, RATED
        return bench

    return once(servo_image, boot)


@pytest.fixture(scope="module")
def found_servo(servo_image, booted_servo):
    """The same behind its first enable, in which the magnet is found."""

    def find(start):
        bench = start.like(booted_servo)
        drive = commanded(bench)
        enable(drive, PROFILE_TORQUE)
        bench.milliseconds(1_050)
        assert drive.state() == OPERATION_ENABLED
        return bench

    return once(servo_image, find)


@pytest.fixture
def starts(servo_image, monkeypatch):
    starts = Starts(servo_image, monkeypatch)
    yield starts
    for bench in starts.benches:
        bench.chip.leave()


@pytest.fixture
def servo(starts, booted_servo):
    return commanded(starts.like(booted_servo))


@pytest.fixture
def found(starts, found_servo):
    return commanded(starts.like(found_servo))


def enable(drive, mode):
    drive[0x6060] = mode
    for word in (SHUTDOWN, SWITCH_ON, ENABLE):
        drive[0x6040] = word
        drive.bench.milliseconds(5)
    drive.until(lambda: drive.state() == OPERATION_ENABLED, "enabled")
    return drive


def test_the_gate_driver_is_set_up_and_no_switch_is_on_before(servo):
    chip = servo.chip
    assert chip.gates.registers == {CONTROL_1: 0x550, CONTROL_2: 0x00C}
    assert servo[0x6041] & 0x10, "the supply is there"
    assert chip.motor.most == 0.0 and chip.tim1.centre.duties() is None
    assert abs(servo[0x6079] - 48_000) < 50


def hold(servo, share):
    """A torque in thousandths, on a rotor that is held."""
    servo.chip.motor.is_held = True
    servo[0x6087] = 10_000
    servo[0x6071] = share
    servo.bench.milliseconds(100)


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
    servo[0x6060] = PROFILE_POSITION
    servo.bench.milliseconds(5)
    servo[0x6081], servo[0x6083], servo[0x6084] = 100_000, 2_000_000, 2_000_000
    target = servo[0x6064] + 5_000
    servo[0x607A] = target
    servo[0x6040] = ENABLE | 0x10
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


def test_the_current_interrupt_is_over_before_its_widths_are_taken(found):
    """In clocks by the model of cost; the loops above the current run in one of five."""
    chip, clocks = found.chip, []
    hold(found, 300)
    chip.core.count_cost()
    served = chip.core.counts[16 + IRQ["ADC"]]
    for _ in range(100):
        before = chip.core.shares.clocks[level(7)]
        chip.run(PERIOD)
        clocks.append(chip.core.shares.clocks[level(7)] - before)
    assert chip.core.counts[16 + IRQ["ADC"]] - served == 100
    print(f"{sum(clocks) / 100:.0f} clocks in the mean, {max(clocks)} at most")
    assert max(clocks) < PERIOD / 2
