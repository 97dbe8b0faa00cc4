"""The plant of the virtual drive on the pins of the chip: a belt with bouncing switches, and a motor that has a mass and follows its field, or does not."""

import pathlib

import pytest
from drive import ENABLE, PROFILE_POSITION
from plant import SimPlant

BELT = pathlib.Path(__file__).parent / "short_belt.toml"
HOMING, ATTAINED, HOMING_ERROR, TARGET_REACHED = 6, 0x1000, 0x2000, 0x0400


@pytest.fixture
def belt(drive, pytestconfig):
    """A drive whose motor moves a belt."""
    plant = SimPlant(drive.chip, pytestconfig.getoption("--plant"), BELT)
    # Its limit switches open at their ends.
    drive[0x2032] = 0b11
    drive.bench.milliseconds(5)
    yield drive, plant
    plant.stop()


@pytest.mark.parametrize(("method", "edge"), [(28, 400), (17, 0)])
def test_homing_and_a_move_on_a_belt_end_where_the_motor_stands(belt, method, edge):
    """By the home switch's positive edge, and by the negative limit switch; then a move, and no current at its end."""
    drive, plant = belt
    drive[0x6098] = method
    drive.sdo[0x6099][1].raw, drive.sdo[0x6099][2].raw = 5_000, 1_000
    drive[0x609A] = 100_000
    drive.enable(HOMING)
    drive[0x6040] = ENABLE | 0x10
    drive.until(lambda: drive[0x6041] & (ATTAINED | HOMING_ERROR), "homed", 3_000)
    drive.until(lambda: drive[0x6041] & TARGET_REACHED, "it stands")
    assert not drive[0x6041] & HOMING_ERROR
    drive.bench.milliseconds(20)
    home = plant.rotor - drive[0x6064]
    # Hysteresis, and the play of the motor in its field: less than a full step.
    assert abs(home - edge) <= 16
    assert plant.edges["PA6" if method == 28 else "PA4"]
    drive[0x6081], drive[0x6083], drive[0x6084] = 10_000, 200_000, 200_000
    drive.enable(PROFILE_POSITION)
    drive[0x607A] = 1_000
    drive[0x6040] = ENABLE | 0x30
    drive.until(lambda: drive[0x6041] & TARGET_REACHED and drive[0x6064] == 1_000, "there")
    drive.bench.milliseconds(20)
    # No step is lost.
    assert abs(plant.rotor - home - 1_000) <= 4
    drive[0x6040] = 0
    drive.bench.milliseconds(20)
    assert not drive.has_power() and not drive.brake_is_open()
    assert abs(plant.rotor - home - 1_000) <= 16
