"""Profile position: moves commanded by PDO end exactly on their targets."""

import pytest

from frames import Frames, wait_until

pytestmark = pytest.mark.own_limits

# Controlword: enable operation, and the bits of the mode.
ENABLE = 0x000F
NEW_SET_POINT = 0x0010
CHANGE_IMMEDIATELY = 0x0020
RELATIVE = 0x0040
HALT = 0x0100

# Statusword.
TARGET_REACHED = 0x0400
SET_POINT_ACKNOWLEDGE = 0x1000
STATE = 0x006F
OPERATION_ENABLED = 0x0027
SWITCH_ON_DISABLED = 0x0040


def remap(pdo, *objects):
    """Maps these objects, for whenever something happens."""
    pdo.clear()
    for index in objects:
        pdo.add_variable(index)
    pdo.trans_type = 255
    pdo.enabled = True
    pdo.save()


class Axis:
    """A drive in Operation enabled: commands go by RPDO 3 (6040h, 607Ah), answers come by TPDO 3 (6041h, 6064h)."""

    def __init__(self, drive):
        self.drive = drive
        drive.sdo[0x6060].raw = 1
        drive.sdo[0x6081].raw = 10_000
        drive.sdo[0x6083].raw = 100_000
        drive.sdo[0x6084].raw = 50_000
        drive.tpdo.read()
        tpdo = drive.tpdo[3]
        remap(tpdo, 0x6041, 0x6064)
        drive.rpdo.read()
        self.rpdo = drive.rpdo[3]
        remap(self.rpdo, 0x6040, 0x607A)
        self.answers = Frames(drive.network, tpdo.cob_id)
        drive.setup_402_state_machine()
        drive.nmt.state = "OPERATIONAL"
        drive.state = "OPERATION ENABLED"

    def command(self, controlword, target=None):
        self.rpdo[0x6040].raw = controlword
        if target is not None:
            self.rpdo[0x607A].raw = target
        self.rpdo.transmit()

    def until(self, mask, bits):
        """Waits for bits of the statusword, and gives the position that came with them."""
        frame = self.answers.until(lambda frame: int.from_bytes(frame[:2], "little") & mask == bits)
        return int.from_bytes(frame[2:], "little", signed=True)

    def set_point(self, target, bits=0, mask=SET_POINT_ACKNOWLEDGE | TARGET_REACHED):
        """Hands over a set-point: the handshake of bit 4 and bit 12, with which bit 10 falls."""
        self.command(ENABLE | NEW_SET_POINT | bits, target)
        self.until(mask, SET_POINT_ACKNOWLEDGE)
        self.command(ENABLE | bits)

    def arrive(self):
        """Waits until the target is reached."""
        self.until(SET_POINT_ACKNOWLEDGE | TARGET_REACHED, TARGET_REACHED)

    def position(self):
        return self.drive.sdo[0x6064].raw

    def demand(self):
        return self.drive.sdo[0x6062].raw


@pytest.fixture
def axis(drive):
    return Axis(drive)


def assert_at(axis, target):
    """The motor is exactly there. The target is reached within a window, so the last steps may still be to come."""
    wait_until(lambda: axis.position() == target, f"6064h = {target}")
    # The demand value is as old as the control tick, so it may follow a pulse by one.
    wait_until(lambda: axis.demand() == target, f"6062h = {target}")
    assert axis.position() == target


@pytest.mark.everywhere
def test_moves_end_on_the_exact_target(axis):
    for target in (5_000, -3_000, 0, 12_345):
        axis.set_point(target)
        axis.arrive()
        assert_at(axis, target)


def test_moves_of_one_step(axis):
    for target in (1, 2, 1, 0, -1):
        # On a busy bus the step may be over before the answer goes out: then bit 10 is not seen to fall.
        axis.set_point(target, mask=SET_POINT_ACKNOWLEDGE)
        axis.arrive()
        assert_at(axis, target)


def test_relative_moves_add_up(axis):
    for count in range(1, 6):
        axis.set_point(777, RELATIVE)
        axis.arrive()
        assert_at(axis, 777 * count)
    axis.set_point(-5 * 777, RELATIVE)
    axis.arrive()
    assert_at(axis, 0)


def test_a_set_point_in_mid_move_takes_over_at_once(axis):
    axis.set_point(1_000_000)
    axis.answers.until(lambda frame: int.from_bytes(frame[2:], "little", signed=True) > 2_000)
    axis.set_point(-1_000, CHANGE_IMMEDIATELY)
    axis.arrive()
    assert_at(axis, -1_000)


def test_a_buffered_set_point_follows(axis):
    axis.set_point(4_000)
    # The second one waits in the buffer: it is acknowledged, and bit 12 stays until the first move has ended.
    axis.command(ENABLE)
    axis.until(SET_POINT_ACKNOWLEDGE, 0)
    axis.command(ENABLE | NEW_SET_POINT, -1_500)
    axis.until(SET_POINT_ACKNOWLEDGE, SET_POINT_ACKNOWLEDGE)
    axis.command(ENABLE)
    axis.arrive()
    wait_until(lambda: axis.position() == -1_500, "6064h = -1500")


def test_halt_pauses_a_move(axis):
    axis.set_point(8_000)
    axis.answers.until(lambda frame: int.from_bytes(frame[2:], "little", signed=True) > 1_000)
    axis.command(ENABLE | HALT)
    axis.until(TARGET_REACHED, TARGET_REACHED)
    stopped = axis.position()
    assert 1_000 < stopped < 8_000
    axis.command(ENABLE)
    axis.until(TARGET_REACHED, 0)
    axis.arrive()
    assert_at(axis, 8_000)


@pytest.mark.everywhere
def test_quick_stop_ends_a_move(axis):
    axis.set_point(1_000_000)
    axis.answers.until(lambda frame: int.from_bytes(frame[2:], "little", signed=True) > 1_000)
    axis.command(0x0002)
    axis.until(0x004F, SWITCH_ON_DISABLED)
    stopped = axis.position()
    assert stopped < 1_000_000
    axis.drive.state = "OPERATION ENABLED"
    # Enabling the drive again does not continue the move.
    assert axis.position() == axis.demand() == stopped


def test_the_software_limit_clips_the_target(axis):
    axis.drive.sdo[0x607D][2].raw = 2_000
    axis.set_point(9_000)
    wait_until(lambda: axis.position() == 2_000, "6064h at the limit")
    assert axis.drive.sdo[0x6041].raw & 0x0800


def test_a_move_commanded_by_sdo_alone(drive):
    drive.sdo[0x6081].raw = 10_000
    for controlword, state in [(0x06, 0x21), (0x07, 0x23), (0x0F, OPERATION_ENABLED)]:
        drive.sdo[0x6040].raw = controlword
        wait_until(lambda: drive.sdo[0x6041].raw & STATE == state, f"state {state:02X}h")
    drive.sdo[0x607A].raw = -2_500
    drive.sdo[0x6040].raw = ENABLE | NEW_SET_POINT
    wait_until(lambda: drive.sdo[0x6041].raw & SET_POINT_ACKNOWLEDGE, "set-point acknowledge")
    drive.sdo[0x6040].raw = ENABLE
    wait_until(lambda: drive.sdo[0x6041].raw & TARGET_REACHED, "target reached")
    wait_until(lambda: drive.sdo[0x6064].raw == -2_500, "6064h = -2500")
