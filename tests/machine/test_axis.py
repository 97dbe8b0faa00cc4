"""An axis with switches: limits end a motion, and homing finds its switch to the pulse."""

import pytest
from drive import ENABLE
from plant import Axis

HOMING = 6
ATTAINED, HOMING_ERROR, TARGET_REACHED = 0x1000, 0x2000, 0x0400

#: Inputs 1 to 3 as the drive comes from the factory; input 3 is wired to the third capture channel too.
NEGATIVE_LIMIT, POSITIVE_LIMIT, HOME = "PA4", "PA5", "PA6+PB11"


def test_a_limit_switch_ends_the_motion_and_lets_it_go_back(drive):
    axis = Axis(drive.chip, {POSITIVE_LIMIT: (2_000, 10_000)})
    drive[0x6085] = 1_000_000
    drive.enable(3)
    drive[0x6083] = drive[0x6084] = 1_000_000
    drive[0x60FF] = 20_000
    drive.until(lambda: axis.edges["PA5"][-1:] and drive[0x606C] == 0, "it stands")
    # 20,000 steps/s at 1,000,000 steps/s² take 200 steps; each millisecond until the switch counts has twenty more.
    assert 2_000 <= drive.settle() <= 2_000 + 300
    drive[0x60FF] = -5_000
    if drive[0x6041] & 8:
        drive[0x6040] = 0x80
    drive.enable(3)
    drive.until(lambda: drive.settle() < 1_900, "off the switch")
    assert drive[0x6064] == pytest.approx(drive.settle(), abs=50)


@pytest.mark.parametrize("method", [24, 28])
def test_homing_finds_its_switch_to_the_pulse(drive, method):
    axis = Axis(drive.chip, {HOME: (500, 900) if method == 24 else (-900, -500)})
    drive[0x6098] = method
    drive.sdo[0x6099][1].raw, drive.sdo[0x6099][2].raw = 20_000, 2_000
    drive[0x609A] = 500_000
    drive.enable(HOMING)
    drive[0x6040] = ENABLE | 0x10
    drive.until(lambda: drive[0x6041] & (ATTAINED | HOMING_ERROR), "homed")
    drive.until(lambda: drive[0x6041] & TARGET_REACHED, "it stands")
    assert not drive[0x6041] & HOMING_ERROR
    # Home is where the last edge came; the pin looks every 20 µs, in which no pulse is missed at 2,000 steps/s.
    (home, _) = axis.edges["PA6"][-1]
    assert drive[0x6064] == drive.settle() - home
