"""The image of `odrive36` with its modulation and its current loop at 40 kHz; the loops above stay at 4 kHz."""

import pytest
from servo_bench import PERIOD, Kind, commanded, hold, interrupts_are_short, move, on_the_way, starting
from stm32f405.image import Image
from test_servo import RATED, begin


@pytest.fixture(scope="module")
def kind(pytestconfig):
    return Kind(Image(pytestconfig.getoption("--servo-40khz-image")), begin, (4_000, RATED))


@pytest.fixture(scope="module")
def found_servo(kind):
    return kind.found(kind.booted())


@pytest.fixture
def found(kind, found_servo, monkeypatch):
    for starts in starting(kind.image, monkeypatch):
        yield commanded(starts.like(found_servo))


def test_a_torque_is_held(found):
    motor = found.chip.motor
    hold(found, 500)
    torque = motor.torque() * 1e3
    assert abs(torque - RATED / 2) < 0.02 * RATED / 2, torque
    assert abs(motor.d) < 0.05
    interrupts_are_short(found.chip, 20, modulation=PERIOD // 2)


def test_a_position_is_reached(found):
    motor = found.chip.motor
    found[0x6081], found[0x6083], found[0x6084] = 100_000, 2_000_000, 2_000_000
    target = move(found, 5_000)
    found.bench.milliseconds(200)
    assert abs(found[0x6064] - target) <= 2 and abs(motor.count - target) <= 2
    assert motor.most < 12.5


def test_the_interrupts_are_short_in_a_move(found):
    on_the_way(found, 100_000, 100_000)
    interrupts_are_short(found.chip, 20, modulation=PERIOD // 2)
