"""Homing by python-canopen's own `BaseNode402.homing()`, and what it leaves behind.

It looks at bits 13, 12 and 10 of the statusword from the moment it has set the start bit on, which it never takes back.

The virtual drive is homed on the ready axes. The image in the emulator has its inputs along the axis too (`cargo xtask qemu --input`), and captures
their edges in its interrupts; so whatever finds home by switches and index pulses is homed there as well. It has no end stop and no driver that
feels one, so the methods -1 to -4 are for the virtual drive alone.
"""

import pathlib

import pytest

from conftest import EDS, NODE_ID, add
from canopen.profiles.p402 import BaseNode402
from frames import wait_until

pytestmark = pytest.mark.own_limits

PLANTS = pathlib.Path(__file__).resolve().parents[2] / "sim" / "plants"

ATTAINED = 0x1000
ERROR = 0x2000
TARGET_REACHED = 0x0400


def prepare(drive, method):
    """Operational, with its PDOs known to python-canopen."""
    drive.sdo[0x6098].raw = method
    drive.sdo[0x6099][1].raw = 20_000
    drive.sdo[0x6099][2].raw = 2_000
    drive.sdo[0x609A].raw = 500_000
    drive.sdo[0x60FD].raw  # it is there
    drive.tpdo.read()
    drive.rpdo.read()
    drive.setup_402_state_machine()
    drive.nmt.state = "OPERATIONAL"
    return drive


def on_axis(start, connect, plant):
    """A virtual drive on one of the ready axes."""
    network = connect(start(arguments=["--plant", PLANTS / plant]))
    return add(network, BaseNode402(NODE_ID, str(EDS)))


@pytest.mark.parametrize("method", [35, 37])
def test_home_is_here(drive, method):
    prepare(drive, method)
    drive.sdo[0x607C].raw = -4_321
    assert drive.homing()
    assert drive.sdo[0x6041].raw & (ERROR | ATTAINED | TARGET_REACHED) == ATTAINED | TARGET_REACHED
    assert drive.sdo[0x6064].raw == -4_321
    assert drive.sdo[0x2034][1].raw == 1


@pytest.mark.everywhere
def test_is_homed_as_long_as_the_home_position_is_known(drive):
    prepare(drive, 37)
    assert not drive.is_homed()
    assert drive.homing()
    assert drive.is_homed()
    # In another mode, and without power, nothing is forgotten.
    drive.op_mode = "PROFILED POSITION"
    drive.state = "SWITCHED ON"
    assert drive.is_homed()
    drive.op_mode = "PROFILED POSITION"
    drive.state = "OPERATION ENABLED"
    assert drive.is_homed()


def test_without_its_switch_homing_fails_and_says_so(drive):
    prepare(drive, 24)
    # No input is for a home switch.
    drive.sdo[0x2031][3].raw = 0
    assert not drive.homing()
    assert drive.sdo[0x6041].raw & (ERROR | ATTAINED) == ERROR
    assert drive.sdo[0x2034][2].raw == 1
    assert drive.sdo[0x6064].raw == 0


@pytest.mark.only("virtual")
@pytest.mark.parametrize("method", [17, 18, 23, 24, 25, 26, 27, 28, 29, 30])
def test_a_belt_is_homed_by_its_switches(start, connect, method):
    drive = prepare(on_axis(start, connect, "belt.toml"), method)
    # Its limit switches are normally closed: the axis brings this setting along.
    assert drive.sdo[0x2032].raw == 0b11
    drive.sdo[0x607C].raw = 100
    assert drive.homing()
    # Home is where the switch was; the motor has gone on for as long as it took to stop.
    assert 0 < abs(drive.sdo[0x6064].raw - 100) < 200


@pytest.mark.only("virtual")
def test_a_motor_with_a_mass_is_homed_and_felt_at_its_stop(start, connect):
    drive = prepare(on_axis(start, connect, "with_motor/belt.toml"), 24)
    assert drive.homing()
    assert abs(drive.sdo[0x6064].raw) < 200
    # Behind the negative limit switch, which is nothing to the drive now, there is a stop; the driver senses it.
    drive.sdo[0x2031][1].raw = 0
    drive.sdo[0x6098].raw = -4
    assert drive.homing()
    assert drive.sdo[0x2034][2].raw == 0
    assert abs(drive.sdo[0x6064].raw) < 500


@pytest.mark.only("virtual")
def test_a_lead_screw_is_homed_by_limit_switch_and_index(start, connect):
    drive = prepare(on_axis(start, connect, "lead_screw.toml"), 1)
    before = drive.sdo[0x6064].raw
    assert before == 0
    assert drive.homing()
    # The motor stood at 60,000, the first index pulse right of the limit switch is at 1,100.
    drive.op_mode = "PROFILED POSITION"
    drive.sdo[0x607A].raw = 58_900
    drive.sdo[0x6081].raw = 50_000
    drive.sdo[0x6040].raw = 0x0F
    drive.sdo[0x6040].raw = 0x1F
    wait_until(lambda: drive.sdo[0x6064].raw == 58_900, "the motor back where it was")


@pytest.mark.only("virtual")
def test_a_limit_switch_that_is_met_is_an_error(start, connect):
    # The home switch is behind the motor: method 19 looks for it in the other direction.
    drive = prepare(on_axis(start, connect, "belt.toml"), 19)
    assert not drive.homing()
    assert drive.sdo[0x60FD].raw & 0b111 == 0b010
    assert drive.sdo[0x2034][2].raw == 2
    # The way back is free.
    drive.sdo[0x6040].raw = 0x0F
    drive.sdo[0x2030][1].raw = 0b10
    assert drive.homing()


#: 2031h: what inputs 1 to 5 are for.
NEGATIVE_LIMIT, POSITIVE_LIMIT, HOME, INDEX, PROBE = 1, 2, 3, 4, 5

#: Where the inputs are high on the axis of the emulator, in steps; index pulses are one step wide.
LIMITS = [f"{NEGATIVE_LIMIT}=..-10000", f"{POSITIVE_LIMIT}=10000.."]
PULSES = [f"{INDEX}={step}..{step}" for step in (-9_200, -400, 400, 2_800, 3_600, 4_400, 5_200, 9_000)]
WINDOW = [f"{HOME}=3000..4000"]
TO_THE_END = [f"{HOME}=3000.."]
FROM_THE_BEGINNING = [f"{HOME}=..3000"]

#: Of each method the home switch, and the step at which home is.
HOMES = {
    1: (WINDOW, -9_200),
    2: (WINDOW, 9_000),
    3: (TO_THE_END, 2_800),
    6: (FROM_THE_BEGINNING, 2_800),
    8: (WINDOW, 3_600),
    10: (WINDOW, 4_400),
    12: (WINDOW, 3_600),
    17: (WINDOW, -10_000),
    18: (WINDOW, 10_000),
    20: (TO_THE_END, 3_000),
    22: (FROM_THE_BEGINNING, 3_000),
    23: (WINDOW, 3_000),
    24: (WINDOW, 3_000),
    26: (WINDOW, 4_000),
    30: (WINDOW, 3_000),
    33: (WINDOW, -400),
    34: (WINDOW, 400),
}


@pytest.mark.only("firmware")
@pytest.mark.parametrize("method", HOMES)
def test_the_firmware_is_homed_by_its_inputs_to_the_step(start, connect, method):
    switch, home = HOMES[method]
    # A mark beside home tells where that is, on the side that is away from the limits.
    side = 1 if home < 0 else -1
    mark = home + side * 500
    inputs = [*LIMITS, *PULSES, *switch, f"{PROBE}={mark}.."]
    arguments = [word for mark in inputs for word in ("--input", mark)]
    drive = prepare(add(connect(start(arguments=arguments)), BaseNode402(NODE_ID, str(EDS))), method)
    drive.sdo[0x2031][4].raw = INDEX
    drive.sdo[0x6099][1].raw = 10_000
    assert drive.homing()
    assert drive.sdo[0x2034][1].raw == 1
    # The edge of the mark, passed upwards, is as far from 0 as the mark is from home.
    drive.op_mode = "PROFILED POSITION"
    for target in (side * 500 - 300, side * 500 + 300):
        drive.sdo[0x607A].raw = target
        drive.sdo[0x6040].raw = 0x0F
        drive.sdo[0x6040].raw = 0x1F
        wait_until(lambda there=target: drive.sdo[0x6064].raw == there, f"6064h = {target}")
        # For the second move: the first positive edge.
        drive.sdo[0x60B8].raw = 0x11
    assert drive.sdo[0x60B9].raw == 0x03
    assert drive.sdo[0x60BA].raw == side * 500
