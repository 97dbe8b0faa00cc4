"""The velocity modes, commanded by python-canopen's `BaseNode402` and by SDO."""

import pytest
from canopen.profiles.p402 import OperationMode

from frames import wait_until

pytestmark = pytest.mark.own_limits

# Controlword: enable operation, bits 4 to 6 of the velocity mode, halt.
ENABLE = 0x000F
RAMP = 0x0070
HALT = 0x0100

# Statusword.
TARGET_REACHED = 0x0400
INTERNAL_LIMIT = 0x0800


@pytest.fixture
def enabled(drive):
    """The drive in Operation enabled."""
    drive.setup_402_state_machine()
    drive.nmt.state = "OPERATIONAL"
    drive.state = "OPERATION ENABLED"
    return drive


def until_velocity(drive, velocity):
    wait_until(lambda: drive.sdo[0x606C].raw == velocity, f"606Ch = {velocity}")


def until_bits(drive, bits):
    wait_until(lambda: drive.sdo[0x6041].raw & bits == bits, f"statusword bits {bits:04X}h")


def test_the_modes_that_are_offered_can_be_entered(enabled):
    for mode in ("PROFILED VELOCITY", "VELOCITY", "NO MODE", "PROFILED POSITION"):
        if mode != "NO MODE":
            assert enabled.is_op_mode_supported(mode)
        enabled.op_mode = mode
        assert enabled.op_mode == mode
    assert not enabled.is_op_mode_supported("PROFILED TORQUE")


@pytest.mark.everywhere
def test_profile_velocity_keeps_the_target_velocity(enabled):
    enabled.op_mode = "PROFILED VELOCITY"
    assert enabled.sdo[0x6061].raw == OperationMode.PROFILED_VELOCITY
    for velocity in (5_000, -2_500, 0):
        enabled.sdo[0x60FF].raw = velocity
        until_velocity(enabled, velocity)
        until_bits(enabled, TARGET_REACHED)
    stopped = enabled.sdo[0x6064].raw
    assert enabled.sdo[0x6064].raw == stopped


def test_halt_stops_profile_velocity_and_release_goes_on(enabled):
    enabled.op_mode = "PROFILED VELOCITY"
    enabled.sdo[0x60FF].raw = 5_000
    until_velocity(enabled, 5_000)
    enabled.sdo[0x6040].raw = ENABLE | HALT
    until_velocity(enabled, 0)
    until_bits(enabled, TARGET_REACHED)
    enabled.sdo[0x6040].raw = ENABLE
    until_velocity(enabled, 5_000)


def test_profile_velocity_ends_at_the_software_limit(enabled):
    enabled.op_mode = "PROFILED VELOCITY"
    enabled.sdo[0x607D][1].raw = -1_000
    enabled.sdo[0x607D][2].raw = 2_000
    for velocity, limit in ((10_000, 2_000), (-10_000, -1_000)):
        enabled.sdo[0x60FF].raw = velocity
        wait_until(lambda end=limit: enabled.sdo[0x6064].raw == end, f"6064h = {limit}")
        until_bits(enabled, INTERNAL_LIMIT)


def test_the_velocity_mode_follows_6042h(enabled):
    enabled.op_mode = "VELOCITY"
    enabled.sdo[0x6040].raw = ENABLE | RAMP
    for velocity in (4_000, -4_000, 0):
        enabled.sdo[0x6042].raw = velocity
        wait_until(lambda shown=velocity: enabled.sdo[0x6044].raw == shown, f"6044h = {velocity}")
    enabled.sdo[0x604C][1].raw = 10
    enabled.sdo[0x6042].raw = 200
    until_velocity(enabled, 2_000)
    assert enabled.sdo[0x6043].raw == 200
    enabled.sdo[0x6040].raw = ENABLE | RAMP & ~0x40
    until_velocity(enabled, 0)


def test_a_mode_change_in_motion_goes_on_from_there(enabled):
    enabled.op_mode = "PROFILED VELOCITY"
    enabled.sdo[0x60FF].raw = 3_000
    until_velocity(enabled, 3_000)
    enabled.op_mode = "PROFILED POSITION"
    until_velocity(enabled, 0)
    enabled.sdo[0x607A].raw = 100
    enabled.sdo[0x6040].raw = ENABLE | 0x10
    enabled.sdo[0x6040].raw = ENABLE
    wait_until(lambda: enabled.sdo[0x6064].raw == 100, "6064h = 100")
