"""The CiA 402 state machine, driven by python-canopen's `BaseNode402`.

With a virtual drive each transition has 0.4 s, the way to a state 0.8 s and a mode 0.5 s, as python-canopen has it (`stepped.py`).
"""

import pytest
from canopen.profiles.p402 import State402

from frames import wait_until

pytestmark = pytest.mark.own_limits

#: Every state that can be commanded, up and down again.
THERE_AND_BACK = [
    "READY TO SWITCH ON",
    "SWITCHED ON",
    "OPERATION ENABLED",
    "SWITCHED ON",
    "READY TO SWITCH ON",
    "SWITCH ON DISABLED",
]

#: Quick stop option code: slow down on the quick stop ramp and stay in Quick stop active.
STAY = 6


@pytest.fixture
def ready(drive):
    """The drive in Operational with its statusword coming by TPDO."""
    drive.setup_402_state_machine()
    drive.nmt.state = "OPERATIONAL"
    drive.state = "SWITCH ON DISABLED"
    return drive


def state_by_sdo(drive):
    """The states that the statusword stands for. It should be one."""
    statusword = drive.sdo[0x6041].raw
    return [state for state, (mask, bits) in State402.SW_MASK.items() if statusword & mask == bits]


def test_the_drive_starts_in_switch_on_disabled(drive):
    assert state_by_sdo(drive) == ["SWITCH ON DISABLED"]


def test_there_and_back(ready):
    for state in THERE_AND_BACK:
        ready.state = state
        assert state_by_sdo(ready) == [state]


@pytest.mark.everywhere
def test_straight_up_from_switch_on_disabled(ready):
    ready.state = "OPERATION ENABLED"
    assert state_by_sdo(ready) == ["OPERATION ENABLED"]


@pytest.mark.parametrize("state", ["READY TO SWITCH ON", "SWITCHED ON", "OPERATION ENABLED"])
def test_disable_voltage_from_every_state(ready, state):
    ready.state = state
    ready.state = "SWITCH ON DISABLED"
    assert state_by_sdo(ready) == ["SWITCH ON DISABLED"]


def test_shutdown_from_operation_enabled(ready):
    ready.state = "OPERATION ENABLED"
    ready.state = "READY TO SWITCH ON"
    assert state_by_sdo(ready) == ["READY TO SWITCH ON"]


@pytest.mark.parametrize("after", ["SWITCH ON DISABLED", "OPERATION ENABLED"])
def test_quick_stop_and_on(ready, after):
    ready.sdo[0x605A].raw = STAY
    ready.state = "OPERATION ENABLED"
    ready.state = "QUICK STOP ACTIVE"
    assert state_by_sdo(ready) == ["QUICK STOP ACTIVE"]
    ready.state = after
    assert state_by_sdo(ready) == [after]


def test_modes_that_are_there(ready):
    assert ready.sdo[0x6502].raw == 0x1E7
    assert ready.is_op_mode_supported("PROFILED POSITION")
    assert ready.is_op_mode_supported("HOMING")
    for code, mode in [(0, "NO MODE"), (1, "PROFILED POSITION"), (6, "HOMING")]:
        ready.sdo[0x6060].raw = code
        wait_until(lambda: ready.op_mode == mode, mode)


@pytest.mark.everywhere
def test_a_fault_is_reset(network, ready):
    # A heartbeat that stays away is a fault while the motor has power (6007h).
    ready.sdo[0x6007].raw = 1
    ready.sdo[0x1016][1].raw = 5 << 16 | 50
    # The drive stays Operational, so that the fault is reset by the state machine alone.
    ready.sdo[0x1029][1].raw = 1
    ready.state = "OPERATION ENABLED"
    network.send_message(0x705, b"\x05")
    wait_until(lambda: ready.state == "FAULT", "the fault")
    assert state_by_sdo(ready) == ["FAULT"]
    assert ready.sdo[0x603F].raw == 0x8130
    # The other node is back, and is not watched any more.
    ready.sdo[0x1016][1].raw = 0
    ready.reset_from_fault()
    assert state_by_sdo(ready) == ["OPERATION ENABLED"]


@pytest.mark.only("virtual")
def test_what_takes_longer_than_python_canopen_waits_is_seen(ready, late):
    ready.op_mode = "PROFILED VELOCITY"
    ready.state = "OPERATION ENABLED"
    ready.sdo[0x60FF].raw = 10_000
    wait_until(lambda: ready.sdo[0x606C].raw == 10_000, "606Ch")
    # Ten seconds on the ramp of 6084h, which 605Ch asks for.
    ready.sdo[0x6084].raw = 1_000
    with pytest.raises(RuntimeError, match="Timeout"):
        ready.state = "SWITCHED ON"
    # One try ends after 0.4 s, the next after 0.8 s.
    assert late == ["SWITCHED ON"] * 2
    late.clear()
    wait_until(lambda: state_by_sdo(ready) == ["SWITCHED ON"], "the end of the ramp")
