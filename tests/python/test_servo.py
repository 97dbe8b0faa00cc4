"""The drive on axes whose motor is moved by its current, commanded by python-canopen over SLCAN."""

import pathlib
import subprocess

import pytest
from canopen.profiles.p402 import BaseNode402

from conftest import NODE_ID, add
from frames import wait_until

ROOT = pathlib.Path(__file__).resolve().parents[2]

#: 6502h: profile torque and cyclic synchronous torque.
TORQUE_MODES = 0x208


@pytest.fixture(scope="module")
def sheet(pytestconfig, tmp_path_factory):
    """The data sheet of the drive with a servo, as masters read it."""
    path = tmp_path_factory.mktemp("servo") / "servo.eds"
    program = pytestconfig.getoption("--od-gen")
    subprocess.run([program, "convert", ROOT / "eds" / "servo.toml", path], check=True, capture_output=True)
    return path


@pytest.mark.parametrize("axis", ["nema17", "nema23", "servo_100w", "servo_400w"])
def test_a_target_torque_is_the_actual_torque(start, connect, sheet, axis):
    network = connect(start(arguments=["--axis", axis]))
    drive = add(network, BaseNode402(NODE_ID, str(sheet)))
    assert drive.sdo[0x6502].raw & TORQUE_MODES == TORQUE_MODES
    drive.setup_402_state_machine()
    drive.nmt.state = "OPERATIONAL"
    # Free to turn, the motor gives its torque until it is as fast as it may be: so it may not be slow.
    drive.sdo[0x6087].raw = 10_000
    drive.state = "OPERATION ENABLED"
    drive.op_mode = "PROFILED TORQUE"
    drive.sdo[0x6071].raw = 100
    wait_until(lambda: drive.sdo[0x6077].raw == 100, "6077h = 100")
    drive.sdo[0x6071].raw = 0
    wait_until(lambda: abs(drive.sdo[0x6077].raw) <= 2, "6077h = 0")
    drive.op_mode = "PROFILED VELOCITY"
    drive.sdo[0x60FF].raw = 0
    wait_until(lambda: drive.sdo[0x606C].raw == 0, "606Ch = 0")
    drive.state = "SWITCHED ON"
