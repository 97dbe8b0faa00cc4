"""The drive on axes whose motor is moved by its current, commanded by python-canopen over SLCAN."""

import json
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


def test_a_motor_is_measured_by_the_command_line(start, connect, programs, sheet, tmp_path):
    bus = start(arguments=["--axis", "servo_100w"])
    network = connect(bus)
    add(network, BaseNode402(NODE_ID, str(sheet))).nmt.state = "OPERATIONAL"
    # From here on there is one master: python-canopen takes the answers for others for its own.
    network.disconnect()
    plot, step = tmp_path / "response.svg", tmp_path / "step.svg"
    master = [str(programs.axis402), *bus.for_axis402(), "--timeout", "5000"]

    def run(*arguments):
        run = subprocess.run([*master, *arguments], capture_output=True, text=True, timeout=300)
        assert run.returncode == 0, (run.stdout, run.stderr)
        return run.stdout

    def tune(*options):
        return json.loads(run("tune", str(NODE_ID), "--bandwidth", "500", "--json", *options))

    def read(*objects):
        told = run("od", "read", "--bare", str(NODE_ID), *objects, "--eds", str(sheet))
        return [int(line.split()[0], 0) for line in told.splitlines()]

    found = tune("--plot", str(plot), "--step", str(step))
    assert found["resistance"] == pytest.approx(0.6, rel=0.03)
    assert found["flux"] == pytest.approx(13.33e-3, rel=0.04)
    assert found["inertia"] == pytest.approx(9.6e-6, rel=0.2)
    assert (found["pole_pairs"], found["direction"]) == (4, 1)
    assert found["response"] and all(picture.read_text().startswith("<svg") for picture in (plot, step))
    assert read("20C2:1", "60F9:1", "60FB:1") == [0, 0, 0], "nothing is written unless it is asked for"
    assert read("6041")[0] & 0x6F == 0x21, "the power stage is off"

    written = tune("--no-response", "--write")
    assert read("20C2:1") == [round(written["resistance"] * 1e6)]
    assert read("60F9:1", "60F9:2", "60FB:1") == written["gains"]
    assert written["gains"][0] == 500
