"""The image of the board `stepper405`, with two full bridges and a stepper with an encoder on its pins."""

import pytest
from bridge_driver import BridgeDriver
from conftest import NODE_ID
from drive import FAULT, FAULT_RESET, OPERATION_ENABLED
from motor import Stepper
from servo_bench import PROFILE_POSITION, Kind, commanded, enable, hold, in_flash, interrupts_are_short, move, on_the_way, starting
from stm32f405 import HZ
from stm32f405.image import Image
from test_end import ENDS
from tuner import is_within_bounds, tune

#: The rated torque of the motor, in mN·m, and what it holds at that current.
RATED = 311
HOLDING = RATED * 1e-3
#: 6075h and 6076h.
RATINGS = (1_700, RATED)
#: Bit 11 and bit 10 of the statusword.
INTERNAL_LIMIT, TARGET_REACHED = 1 << 11, 1 << 10
#: 20C4h:1: what is held back is made up while the demand is at rest.
MADE_UP_AT_REST = 2


def begin(start, **how):
    """A chip with bridges and a motor."""
    bench = start(**how)
    chip = bench.chip
    # 25 °C at the thermistor.
    chip.adc.levels[15] = 1_015
    chip.pins.drive("PD2", 0)
    chip.driver = BridgeDriver(chip, "PB13", "PA3")
    chip.motor = Stepper(chip)
    chip.driver.on_change = chip.motor.changed
    return bench


@pytest.fixture(scope="module")
def kind(pytestconfig):
    return Kind(Image(pytestconfig.getoption("--stepper-image")), begin, RATINGS)


@pytest.fixture(scope="module")
def booted_stepper(kind):
    return kind.booted()


@pytest.fixture(scope="module")
def found_stepper(kind, booted_stepper):
    return kind.found(booted_stepper)


@pytest.fixture
def starts(kind, monkeypatch):
    yield from starting(kind.image, monkeypatch)


@pytest.fixture
def stepper(starts, booted_stepper):
    return commanded(starts.like(booted_stepper))


@pytest.fixture
def found(starts, found_stepper):
    return commanded(starts.like(found_stepper))


def has_current(chip):
    return chip.motor.switched() is not None


def test_the_stage_is_ready_and_no_switch_is_on_before(stepper):
    chip = stepper.chip
    assert stepper[0x6041] & 0x10, "the supply is there"
    assert chip.motor.most == 0.0 and not chip.driver.is_on
    assert not chip.pins.changes("PB13") or max(level or 0 for _, level in chip.pins.changes("PB13")) == 0
    assert abs(stepper[0x6079] - 24_000) < 50


def test_a_torque_is_held_and_a_fault_of_the_bridges_takes_the_current_at_once(found):
    stepper, chip, motor = found, found.chip, found.chip.motor
    hold(stepper, 500)
    torque = motor.torque() * 1e3
    assert abs(torque - RATED / 2) < 0.02 * RATED / 2, torque
    assert abs(motor.d) < 0.05
    assert abs(stepper[0x6077] - 500) <= 5
    chip.driver.breaks()
    chip.run(HZ // 200_000)
    assert not has_current(chip), "5 us later"
    stepper.until(lambda: stepper.state() == FAULT, "fault")
    assert stepper[0x603F] == 0x5400
    assert not has_current(chip)
    # As long as it is there nothing clears it, and then the next try does.
    stepper[0x6040] = FAULT_RESET
    stepper.bench.milliseconds(210)
    assert stepper.state() == FAULT and not has_current(chip)
    chip.driver.breaks(False)
    stepper.bench.milliseconds(210)
    stepper[0x6040] = 0
    stepper[0x6040] = FAULT_RESET
    stepper.bench.milliseconds(5)
    enable(stepper, PROFILE_POSITION)
    stepper.bench.milliseconds(20)
    assert stepper.state() == OPERATION_ENABLED and has_current(chip)


def test_a_move_ends_where_the_encoder_was_to_be(found):
    stepper, motor = found, found.chip.motor
    stepper[0x6081], stepper[0x6083], stepper[0x6084] = 20_000, 400_000, 400_000
    target = move(stepper, 4_096)
    stepper.until(lambda: stepper[0x6041] & TARGET_REACHED, "there", 400)
    stepper.bench.milliseconds(100)
    assert stepper[0x6064] == motor.count == target
    assert motor.most < 2.5


def test_a_load_beyond_the_holding_torque_costs_no_step(found):
    """It brakes for a while, with the rotor where it is; what was held back is made up."""
    stepper, motor = found, found.chip.motor
    stepper[0x6040] = 0
    stepper.bench.milliseconds(5)
    stepper.sdo[0x20C4][1].raw = MADE_UP_AT_REST
    enable(stepper, PROFILE_POSITION)
    stepper.bench.milliseconds(20)
    stepper[0x6081], stepper[0x6083], stepper[0x6084] = 10_000, 200_000, 200_000
    target = move(stepper, 1_500)
    stepper.bench.milliseconds(60)
    free, motor.friction = motor.friction, 1.4 * HOLDING
    stepper.bench.milliseconds(200)
    assert stepper[0x6041] & (INTERNAL_LIMIT | TARGET_REACHED) == INTERNAL_LIMIT, "held back"
    assert stepper[0x6062] == target, "the profile has ended, the motor has not"
    assert abs(stepper[0x6064] - motor.count) <= 1 and target - motor.count > 500
    motor.friction = free
    stepper.until(lambda: stepper[0x6041] & TARGET_REACHED, "made up")
    stepper.bench.milliseconds(100)
    assert stepper[0x6064] == motor.count == target
    assert not stepper[0x6041] & INTERNAL_LIMIT


#: What the loops go by, and their gains: 0 is that of the board.
SET = [(0x20C2, sub) for sub in range(1, 6)] + [(0x60F9, 1), (0x60F9, 2), (0x60FB, 1)]


# Three and a half seconds of the motor: half a minute of a processor that does nothing else.
@pytest.mark.timeout(900)
def test_axis402_tune_measures_the_motor_and_writes_nothing(starts, booted_stepper, pytestconfig):
    bench = starts.like(booted_stepper)
    found = tune(bench, pytestconfig.getoption("--tuner"), NODE_ID)
    motor = bench.chip.motor
    assert not found["is_written"]
    is_within_bounds(found, motor, HOLDING)
    assert motor.most < 1.25 * 1.7
    stepper = commanded(bench)
    stepper.until(lambda: not has_current(bench.chip), "without power", 50)
    assert [stepper.sdo[index][sub].raw for index, sub in SET] == [0] * len(SET)


@pytest.mark.parametrize("end", ENDS, ids=lambda end: end.__name__)
def test_the_motor_has_no_current_within_a_millisecond(found, end):
    chip = found.chip
    hold(found, 300)
    assert has_current(chip) and chip.pins.level("PC2") == 1
    end(chip)
    chip.run(HZ // 1_000)
    assert not has_current(chip) and chip.pins.level("PB13") == 0 and chip.pins.level("PC2") == 0


def test_the_interrupts_are_short(found):
    """The converters end twice in a period, and once for nothing."""
    hold(found, 300)
    interrupts_are_short(found.chip, 20, more=1)


@pytest.mark.parametrize("way", (0, 1, MADE_UP_AT_REST, 3))
def test_they_are_in_a_move_too_however_the_lead_is_bound(found, way):
    found[0x6040] = 0
    found.bench.milliseconds(5)
    found.sdo[0x20C4][1].raw = way
    enable(found, PROFILE_POSITION)
    found.bench.milliseconds(20)
    on_the_way(found, 20_000, 40_960)
    interrupts_are_short(found.chip, 20, more=1)


def test_what_the_current_interrupt_does_in_each_period_runs_in_ram(found):
    hold(found, 300)
    assert not set.intersection(*in_flash(found.chip, 10))
