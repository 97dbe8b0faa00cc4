"""Cyclic synchronous position: python-canopen is the master of SYNC, and gives a set-point in every period."""

import struct

import pytest

from conftest import NODE_ID
from frames import Frames, wait_until

#: In milliseconds. A master in Python on a busy PC is no better than that, and pauses now and then.
PERIOD = 20

#: 2051h:2: where no set-point comes, the one before holds.
HOLD = 2

#: Statusword: the drive follows the command value.
FOLLOWS = 0x1000

ENABLE = 0x000F


@pytest.fixture
def following(drive):
    """The drive in Operation enabled and mode 8. RPDO 3 (6040h, 607Ah) and TPDO 4 (6064h, 6062h) are synchronous."""
    drive.sdo[0x60C2][1].raw = PERIOD
    drive.sdo[0x60C2][2].raw = -3
    drive.sdo[0x2051][2].raw = HOLD
    drive.sdo[0x1402][2].raw = 1
    drive.sdo[0x1803][2].raw = 1
    drive.setup_402_state_machine()
    drive.nmt.state = "OPERATIONAL"
    drive.op_mode = "CYCLIC SYNCHRONOUS POSITION"
    drive.state = "OPERATION ENABLED"
    return drive


# On SocketCAN python-canopen leaves SYNC to the kernel's broadcast manager, which the small kernel of the tests has not.
@pytest.mark.only("virtual", "firmware")
def test_the_motor_follows_set_points_at_sync(network, following):
    answers = Frames(network, 0x480 + NODE_ID)
    network.sync.start(PERIOD / 1000)
    target = 0
    for way in (25, -10, 0):
        for _ in range(60):
            target += way
            network.send_message(0x400 + NODE_ID, struct.pack("<Hi", ENABLE, target))
            # One for each SYNC.
            answers.next()
    assert target == 900
    wait_until(lambda: following.sdo[0x6064].raw == target, "at the last set-point")
    assert following.sdo[0x6062].raw == target
    assert following.sdo[0x6061].raw == 8
    wait_until(lambda: following.sdo[0x6041].raw & FOLLOWS, "bit 12")
    assert following.sdo[0x603F].raw == 0
    network.sync.stop()
    following.state = "SWITCHED ON"
    assert following.sdo[0x6064].raw == target
