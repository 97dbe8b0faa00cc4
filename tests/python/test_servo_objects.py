"""Each object of a servo and each of its modes, commanded by python-canopen on virtual time: `stepped_drive --axis`."""

import struct

import canopen
import pytest
from canopen.profiles.p402 import BaseNode402

from conftest import NODE_ID, add
from frames import Frames, wait_until
from test_servo import sheet  # noqa: F401 - a fixture

pytestmark = [pytest.mark.own_limits, pytest.mark.only("virtual")]

# Statusword.
WARNING = 0x0080
TARGET_REACHED = 0x0400
INTERNAL_LIMIT = 0x0800
FOLLOWS = 0x1000

#: A torque that nothing turns against, in N·m.
HELD = 20

AXES = ["nema17", "nema23", "servo_100w", "servo_400w"]


class Servo:
    """A drive in operation enabled, and what happens to its motor."""

    def __init__(self, bus, network, sheet):
        self.bus = bus
        self.network = network
        self.drive = add(network, BaseNode402(NODE_ID, str(sheet)))
        self.read = lambda index, sub=None: self.entry(index, sub).raw
        self.drive.setup_402_state_machine()
        self.drive.nmt.state = "OPERATIONAL"

    def entry(self, index, sub=None):
        return self.drive.sdo[index] if sub is None else self.drive.sdo[index][sub]

    def write(self, index, value, sub=None):
        self.entry(index, sub).raw = value

    def enable(self, mode):
        self.drive.op_mode = mode
        self.drive.state = "OPERATION ENABLED"
        return self

    def happen(self, *events):
        for event in events:
            self.bus.happen(event)

    def run(self, seconds):
        self.bus.run(seconds)

    def word(self):
        return self.read(0x6041)

    def until(self, index, wanted, within, sub=None):
        wait_until(lambda: abs(self.read(index, sub) - wanted) <= within, f"{index:04X}h = {wanted}")

    def refuses(self, index, value, code, sub=None):
        with pytest.raises(canopen.SdoAbortedError) as refusal:
            self.write(index, value, sub)
        assert refusal.value.code == code
        return refusal


@pytest.fixture
def servo(start, connect, sheet):  # noqa: F811
    """Makes a drive on a ready axis."""

    def servo(axis):
        bus = start(arguments=["--axis", axis])
        return Servo(bus, connect(bus), sheet)

    return servo


def test_the_drive_says_what_it_is(servo):
    one = servo("servo_100w")
    assert one.read(0x1008) == "Axis402 servo drive"
    assert one.read(0x1018, 2) == 0x403
    for mode in ("PROFILED POSITION", "PROFILED VELOCITY", "PROFILED TORQUE", "HOMING"):
        assert one.drive.is_op_mode_supported(mode)
    for mode in ("CYCLIC SYNCHRONOUS POSITION", "CYCLIC SYNCHRONOUS VELOCITY", "CYCLIC SYNCHRONOUS TORQUE"):
        assert one.drive.is_op_mode_supported(mode)


@pytest.mark.parametrize(("axis", "current", "torque"), [("nema17", 1_700, 311), ("servo_400w", 17_000, 1_275)])
def test_what_thousandths_are_of(servo, axis, current, torque):
    one = servo(axis)
    assert (one.read(0x6075), one.read(0x6076)) == (current, torque)
    one.enable("PROFILED TORQUE").happen(f"brake {HELD}")
    one.write(0x6071, 300)
    one.until(0x6077, 300, 2)
    # With no current along the magnet one is as much as the other, and the demand is both.
    assert abs(one.read(0x6078) - 300) <= 3 and one.read(0x6074) == 300
    # The voltage of the bus, in mV.
    bus = {"nema17": 24_000, "servo_400w": 48_000}[axis]
    assert abs(one.read(0x6079) - bus) < bus // 50


#: What holds a target of 800 ‰ down to 300 ‰, and in which direction.
LIMITS = [
    (0x6072, (1, -1)),
    (0x6073, (1, -1)),
    (0x60E0, (1,)),
    (0x60E1, (-1,)),
]


@pytest.mark.parametrize("axis", ["nema23", "servo_100w"])
def test_each_limit_of_the_torque_holds_and_is_told(servo, axis):
    one = servo(axis).enable("PROFILED TORQUE")
    one.happen(f"brake {HELD}")
    one.write(0x6087, 100_000)
    for limit, directions in LIMITS:
        before = one.read(limit)
        one.write(limit, 300)
        for sign in (1, -1):
            most = 300 if sign in directions else 800
            one.write(0x6071, 800 * sign)
            one.until(0x6077, most * sign, 4)
            assert (one.word() & INTERNAL_LIMIT != 0) == (most == 300), f"{limit:04X}h, {sign}"
        one.write(limit, before)
        one.write(0x6071, 0)
        one.until(0x6077, 0, 2)


def test_the_slope_is_linear_and_nothing_else(servo):
    one = servo("servo_100w")
    one.refuses(0x6088, 1, 0x06090030)
    one.write(0x6088, 0)
    one.write(0x6087, 500)
    one.enable("PROFILED TORQUE").happen(f"brake {HELD}")
    one.write(0x6071, 400)
    one.run(0.1)
    begin = one.read(0x6074)
    one.run(0.4)
    assert abs(one.read(0x6074) - begin - 200) <= 4
    assert not one.word() & TARGET_REACHED
    one.until(0x6074, 400, 0)
    wait_until(lambda: one.word() & TARGET_REACHED, "bit 10")


def test_a_torque_turns_the_motor_no_faster_than_6080h(servo):
    one = servo("servo_100w")
    one.write(0x6080, 600)
    one.enable("PROFILED TORQUE")
    one.write(0x6071, 300)
    # In counts/s. The limit falls towards that speed, and the friction of the machine is a little of it.
    one.run(2.0)
    assert 85_000 < one.read(0x606C) <= 100_000


#: Mode, its set-point, and what the actual value is.
CYCLIC = [
    ("CYCLIC SYNCHRONOUS POSITION", 0x607A, 0x6064),
    ("CYCLIC SYNCHRONOUS VELOCITY", 0x60FF, 0x606C),
    ("CYCLIC SYNCHRONOUS TORQUE", 0x6071, 0x6077),
]


def map_set_point(one, index, length):
    """The set-point in RPDO 2, taken over at SYNC each 4 ms."""
    one.write(0x1401, one.read(0x1401, 1) | 1 << 31, 1)
    one.write(0x1601, 0, 0)
    one.write(0x1601, index << 16 | 8 * length, 1)
    one.write(0x1601, 1, 0)
    one.write(0x1401, 1, 2)
    one.write(0x1401, 0x300 + NODE_ID, 1)
    one.write(0x60C2, 4, 1)
    # Where none comes, as while an object is read, the one before holds.
    one.write(0x2051, 2, 2)


def give(one, value, times, length):
    for _ in range(times):
        if value is not None:
            one.network.send_message(0x300 + NODE_ID, struct.pack({2: "<h", 4: "<i"}[length], value))
        one.network.send_message(0x80, b"")
        one.run(0.004)


@pytest.mark.parametrize("axis", ["nema17", "servo_100w"])
@pytest.mark.parametrize(("mode", "index", "actual"), CYCLIC, ids=["csp", "csv", "cst"])
def test_set_points_at_sync_are_followed(servo, axis, mode, index, actual):
    one = servo(axis)
    length = 2 if index == 0x6071 else 4
    map_set_point(one, index, length)
    one.enable(mode)
    if index == 0x6071:
        one.happen(f"brake {HELD}")
    steps = {0x607A: range(0, 800, 10), 0x60FF: range(0, 8_000, 100), 0x6071: range(0, 240, 3)}[index]
    for value in steps:
        give(one, value, 1, length)
    give(one, steps[-1], 40, length)
    assert abs(one.read(actual) - steps[-1]) <= (200 if index == 0x60FF else 2)
    assert one.word() & FOLLOWS
    assert one.read(0x603F) == 0
    # What is added to it: 60B2h to a torque.
    if index == 0x6071:
        one.write(0x60B2, 30)
        give(one, steps[-1], 10, length)
        assert abs(one.read(actual) - steps[-1] - 30) <= 2


def test_what_is_given_ahead_of_the_loops(servo):
    one = servo("servo_100w")
    map_set_point(one, 0x607A, 4)
    one.write(0x60FB, 100, 1)
    one.enable("CYCLIC SYNCHRONOUS POSITION")
    give(one, 0, 40, 4)
    # A velocity ahead is taken back by the position loop: 5,000 counts/s by 100 1/s.
    one.write(0x60B1, 5_000)
    give(one, 0, 60, 4)
    assert abs(one.read(0x6064) - 50) <= 2 and abs(one.read(0x60F4) + 50) <= 2
    one.write(0x60B1, 0)
    # A torque ahead of the load that comes, 0.15 N·m less the friction of the machine: it displaces the rotor by less.
    sags = []
    for offset in (0, 300):
        one.write(0x60B2, 0)
        one.happen("load 0")
        give(one, 0, 60, 4)
        one.happen("load 0.15")
        one.write(0x60B2, offset)
        worst = 0
        for _ in range(5):
            give(one, 0, 1, 4)
            worst = max(worst, abs(one.read(0x6064)))
        sags.append(worst)
    assert sags[1] < sags[0], sags


def test_an_offset_of_the_velocity_is_part_of_the_set_point(servo):
    one = servo("servo_100w")
    map_set_point(one, 0x60FF, 4)
    one.enable("CYCLIC SYNCHRONOUS VELOCITY")
    for offset in (20_000, -20_000, 0):
        one.write(0x60B1, offset)
        give(one, 60_000, 60, 4)
        assert abs(one.read(0x606C) - 60_000 - offset) <= 400


@pytest.mark.parametrize("axis", AXES)
def test_position_and_velocity_on_each_axis(servo, axis):
    one = servo(axis).enable("PROFILED POSITION")
    for target in (6_000, -300):
        one.write(0x607A, target)
        one.drive.controlword = 0x3F
        one.run(0.05)
        one.drive.controlword = 0x0F
        one.until(0x6064, target, 1)
        wait_until(lambda: one.word() & TARGET_REACHED, "bit 10")
    one.drive.op_mode = "PROFILED VELOCITY"
    one.write(0x60FF, 8_000)
    one.until(0x606C, 8_000, 120)
    # Changed in flight to a torque and back: no fault, and no jump.
    one.drive.op_mode = "PROFILED TORQUE"
    one.run(0.02)
    assert abs(one.read(0x6077)) < 700
    one.drive.op_mode = "PROFILED VELOCITY"
    one.write(0x60FF, 0)
    one.until(0x606C, 0, 20)
    assert one.read(0x603F) == 0


@pytest.mark.parametrize("way", [0, 2, 3])
def test_home_is_a_hard_stop_that_the_torque_finds(servo, way):
    one = servo("nema17")
    one.write(0x20C4, way, 1)
    one.write(0x20C5, 0, 1)
    one.write(0x6065, 0xFFFF_FFFF)
    one.write(0x60E0, 600)
    for index, sub, value in [(0x6098, None, -3), (0x6099, 1, 4_000), (0x6099, 2, 1_000), (0x609A, None, 100_000)]:
        one.write(index, value, sub)
    one.enable("HOMING")
    one.drive.controlword = 0x1F
    wait_until(lambda: one.read(0x6064) >= 1_000, "on its way")
    one.happen(f"brake {HELD}")
    wait_until(lambda: one.word() & 0x3000, "homing attained, or an error")
    one.happen("brake 0")
    wait_until(lambda: one.word() & 0x3400 == 0x1400, "attained, and at rest")
    one.until(0x6064, 0, 2)


#: Of each: value, and what is read back; then one that its limits refuse, with the code.
SETTINGS = [
    (0x60F6, 1, 500, 1_001, 0x06090031),
    (0x60F9, 1, 400, 10_001, 0x06090031),
    (0x60F9, 2, 130, 10_001, 0x06090031),
    (0x60FB, 1, 130, 10_001, 0x06090031),
    (0x20C0, 2, 500, 9, 0x06090032),
    (0x20C0, 3, 100, 19, 0x06090032),
    (0x20C0, 4, 500, 5_001, 0x06090031),
    (0x20C0, 5, 200, 3_001, 0x06090031),
    (0x20C0, 6, 200, 0, 0x06090032),
    (0x20C0, 7, 900, 4_001, 0x06090031),
    (0x20C0, 8, 400, 9, 0x06090032),
    (0x20C3, 1, 600, 1_501, 0x06090031),
    (0x20C3, 2, 600, 2_001, 0x06090031),
    (0x20C3, 3, 300, 1_501, 0x06090031),
    (0x20C3, 4, 900, 99, 0x06090032),
    (0x20C4, 1, 2, 4, 0x06090031),
    (0x20C4, 2, 130, 109, 0x06090032),
    (0x20C4, 3, 900, 0, 0x06090032),
    (0x20C4, 4, 900, 49, 0x06090032),
    (0x20C4, 5, 300, 1_001, 0x06090031),
    (0x20C4, 6, 40, 0, 0x06090032),
    (0x20C5, 1, 300, None, 0),
    (0x20C5, 2, 30, 0, 0x06090032),
]


def test_what_can_be_set_is_kept_within_its_limits_and_the_motor_goes_on(servo):
    one = servo("nema17")
    for index, sub, value, refused, code in SETTINGS:
        one.write(index, value, sub)
        if refused is not None:
            one.refuses(index, refused, code, sub)
        assert one.read(index, sub) == value, f"{index:04X}h:{sub}"
    for sub, value in enumerate([1_700_000, 3_300_000, 3_300_000, 3_700_000, 11_000_000, 4_000, 800], 1):
        one.write(0x20C2, value, sub)
        assert one.read(0x20C2, sub) == value
    for sub in range(1, 15):
        # Nothing was measured yet, and what was cannot be written.
        assert one.read(0x20C1, sub) == 0
        one.refuses(0x20C1, 1, 0x06010002, sub)
    for index in (0x6074, 0x6077, 0x6078, 0x6079):
        one.refuses(index, 1, 0x06010002)
    one.refuses(0x20C4, 1, 0x06010002, 7)
    one.enable("PROFILED POSITION")
    one.write(0x607A, 2_000)
    one.drive.controlword = 0x1F
    # These values fit no motor: it hunts about the target by some counts.
    one.until(0x6064, 2_000, 20)
    assert one.read(0x603F) == 0


@pytest.mark.parametrize("way", [2, 3])
def test_a_stepper_makes_up_what_a_load_held_back(servo, way):
    one = servo("nema17")
    one.write(0x20C4, way, 1)
    one.write(0x20C5, 0, 1)
    one.write(0x6065, 0xFFFF_FFFF)
    one.enable("PROFILED POSITION")
    one.happen("brake 0.5")
    one.write(0x607A, 4_000)
    one.drive.controlword = 0x1F
    wait_until(lambda: one.word() & INTERNAL_LIMIT, "bit 11")
    one.run(1.0)
    # Held back: the demand has ended, the encoder has not come, and the lead is at its bound of 1.5 full steps.
    assert one.read(0x6062) == 4_000
    assert one.read(0x60F4) > 3_000
    assert not one.word() & TARGET_REACHED
    assert 140 <= one.read(0x20C4, 7) <= 150
    one.happen("brake 0")
    wait_until(lambda: one.word() & (TARGET_REACHED | INTERNAL_LIMIT) == TARGET_REACHED, "bit 10 and not 11")
    one.until(0x6064, 4_000, 1)


def test_a_supervised_stepper_tells_what_it_loses(servo):
    one = servo("nema17")
    one.write(0x20C4, 1, 1)
    one.write(0x20C5, 0, 1)
    one.write(0x6065, 0xFFFF_FFFF)
    one.enable("PROFILED POSITION")
    one.happen("brake 0.5")
    one.write(0x607A, 4_000)
    one.drive.controlword = 0x1F
    wait_until(lambda: one.word() & INTERNAL_LIMIT, "bit 11")
    # At rest too far from its field for it ever to come back.
    wait_until(lambda: one.read(0x603F) == 0x8611, "8611h")


def test_a_measurement_is_told_and_ends(servo):
    one = servo("servo_100w").enable("PROFILED POSITION")
    one.write(0x20C0, 500, 4)
    one.write(0x20C0, 1, 1)
    states = set()

    def is_over():
        states.add(one.read(0x20C1, 1))
        return states & {6, 7}

    wait_until(is_over, "done, or failed")
    assert {2, 3, 4, 6} <= states and 7 not in states
    assert one.read(0x20C0, 1) == 0
    found = [one.read(0x20C1, sub) for sub in range(3, 15)]
    assert found[0] == pytest.approx(600_000, rel=0.04)
    assert found[3] == pytest.approx(13_330_000, rel=0.04)
    assert found[4:6] == [4, 1]
    assert found[9] == 500
    # The sine is one of the current, as long as it was ordered.
    for sub, value in [(5, 200), (6, 200), (7, 900), (8, 300)]:
        one.write(0x20C0, value, sub)
    one.write(0x20C0, 2, 1)
    one.run(0.1)
    assert one.read(0x20C1, 1) == 5
    wait_until(lambda: one.read(0x20C1, 1) == 6, "done")


#: What happens, the mode in which it does, the codes that tell of it, and how long it may take in s.
FAULTS = [
    ("servo_100w", ["cut-supply"], "PROFILED VELOCITY", [0x3220], 2.0),
    ("servo_100w", ["charge 72"], "PROFILED VELOCITY", [0x3210], 0.1),
    ("servo_100w", ["short 0"], "PROFILED VELOCITY", [0x2320], 0.1),
    ("nema17", ["short 0"], "PROFILED VELOCITY", [0x2310], 0.1),
    ("servo_400w", ["brake 0.05", "cut-phase 1"], "PROFILED VELOCITY", [0x7122, 0x7305], 1.0),
    ("servo_100w", ["cut-encoder"], "PROFILED VELOCITY", [0x7305, 0x7121], 1.5),
    ("servo_100w", ["lose-counts 7"], "PROFILED VELOCITY", [0x7305], 0.5),
    ("nema23", ["slip-index 9"], "PROFILED VELOCITY", [0x7305], 0.5),
    ("servo_100w", ["stuck-current 1 3.0"], "PROFILED VELOCITY", [0x7300], 0.1),
    ("servo_100w", [f"brake {HELD}"], "PROFILED VELOCITY", [0x7121], 2.0),
    ("servo_100w", ["heat 1050"], "PROFILED VELOCITY", [0x4310, 0x4210], 1.0),
    ("servo_100w", ["load -0.2"], "PROFILED TORQUE", [0x7310], 2.0),
]


@pytest.mark.parametrize(
    ("axis", "events", "mode", "codes", "within"), FAULTS, ids=[f"{fault[0]}-{fault[1][-1]}" for fault in FAULTS]
)
def test_what_breaks_is_an_emergency_and_takes_the_power(servo, axis, events, mode, codes, within):
    one = servo(axis)
    one.write(0x6065, 0xFFFF_FFFF)
    emergencies = Frames(one.network, 0x80 + NODE_ID)
    one.enable(mode)
    if mode == "PROFILED VELOCITY":
        one.write(0x60FF, 10 * one.read(0x608F, 1))
        one.run(0.3)
        assert one.read(0x603F) == 0
    else:
        one.write(0x6072, 50)
    one.happen(*events)
    # What watches the supply of the board may tell of the same before.
    emergency = emergencies.until(lambda frame: struct.unpack_from("<H", frame)[0] in codes, within)
    assert emergency[2] & 1, "error register"
    assert one.read(0x603F) in codes
    assert one.read(0x1003, 1) & 0xFFFF in codes
    one.run(0.05)
    assert abs(one.read(0x6077)) <= 2 and abs(one.read(0x6078)) <= 2, "no current"
    # At rest it is in fault; what is mended can be left then: EMCY 0000h, and the motor goes on.
    one.happen("mend", "brake 0.02")
    wait_until(lambda: one.word() & 0x4F == 0x08, "fault")
    one.write(0x60FF, 0)
    one.drive.controlword = 0x80
    wait_until(lambda: one.word() & 0x4F == 0x40, "switch on disabled")
    emergencies.until(lambda frame: frame[:2] == b"\0\0", 0.5)
    one.enable("PROFILED VELOCITY")
    one.write(0x6072, 1_000)
    one.write(0x60FF, 10_000)
    one.until(0x606C, 10_000, 400)
    assert one.word() & 0x6F == 0x27


def test_a_following_error_is_an_emergency(servo):
    one = servo("servo_100w")
    one.write(0x6065, 500)
    one.write(0x6066, 10)
    emergencies = Frames(one.network, 0x80 + NODE_ID)
    one.enable("PROFILED VELOCITY")
    one.write(0x60FF, 50_000)
    one.run(0.2)
    one.happen(f"brake {HELD}")
    assert struct.unpack_from("<H", emergencies.next(1.0)) == (0x8611,)


def test_heat_of_the_motor_is_warned_of_and_then_holds_it_back(servo):
    one = servo("servo_100w")
    one.write(0x6087, 100_000)
    emergencies = Frames(one.network, 0x80 + NODE_ID)
    one.enable("PROFILED TORQUE").happen(f"brake {HELD}")
    one.write(0x6071, 2_500)
    one.until(0x6077, 2_500, 15)
    assert not one.word() & WARNING
    # I²t is spent after three seconds; 2350h comes before, and operation goes on.
    assert struct.unpack_from("<H", emergencies.next(3.5)) == (0x2350,)
    assert one.word() & WARNING and one.word() & 0x6F == 0x27
    # Then what is left is the rated torque, and a rotor that is held is blocked at that limit.
    assert struct.unpack_from("<H", emergencies.next(1.0)) == (0x7121,)
