"""The images of two products on the servo boards: the LMD on `stepper405`, the S200 on `odrive36`. The module of each is told what the loops of the
chip do, and sets them up."""

import canopen
import pytest
from canopen.profiles.p402 import BaseNode402
from conftest import ROOT, once
from drive import Drive
from servo_bench import PROFILE_POSITION, PROFILE_TORQUE, enable, hold, interrupts_are_short, on_the_way, starting
from stm32f405.image import Image
from test_servo import begin as begin_servo
from test_stepper import begin as begin_stepper

#: What thousandths of torque of the LMD are of, in mN·m: the motor of the board.
RATED_TORQUE = 311


class Product:
    """An image on its board, and the node-ID that it leaves the factory with."""

    def __init__(self, name, node, image, begin):
        self.node, self.image, self.begin = node, image, begin
        self.sheet = canopen.import_od(str(ROOT / "products" / name / f"{name}.eds"), node)

    def commanded(self, bench):
        node = BaseNode402(self.node, self.sheet)
        bench.network.add_node(node)
        return Drive(bench, node)

    def found(self):
        """The bench of one behind its first enable, in which the magnet is found."""

        def find(start):
            bench = self.begin(start)
            bench.chip.run(20_000_000, lambda: bench.frames)
            bench.milliseconds(60)
            drive = self.commanded(bench)
            enable(drive, PROFILE_POSITION)
            bench.milliseconds(1_050)
            return bench

        return once(self.image, find)


@pytest.fixture(scope="module")
def lmd(pytestconfig):
    return Product("lmd", 65, Image(pytestconfig.getoption("--lmd-image")), begin_stepper)


@pytest.fixture(scope="module")
def s200(pytestconfig):
    return Product("s200", 1, Image(pytestconfig.getoption("--s200-image")), begin_servo)


@pytest.fixture(scope="module")
def found_lmd(lmd):
    return lmd.found()


@pytest.fixture(scope="module")
def found_s200(s200):
    return s200.found()


@pytest.fixture
def stepper(lmd, found_lmd, monkeypatch):
    for starts in starting(lmd.image, monkeypatch):
        yield lmd.commanded(starts.like(found_lmd))


@pytest.fixture
def servo(s200, found_s200, monkeypatch):
    for starts in starting(s200.image, monkeypatch):
        yield s200.commanded(starts.like(found_s200))


def test_a_turn_of_the_lmd_is_51200_microsteps_of_an_encoder_with_4096_counts(stepper):
    motor = stepper.chip.motor
    begun, from_there = motor.count, stepper[0x6064]
    stepper[0x6081], stepper[0x6083], stepper[0x6084] = 200_000, 4_000_000, 4_000_000
    stepper[0x607A] = from_there + 51_200
    stepper[0x6040] = 0x1F
    stepper.bench.milliseconds(500)
    assert abs(motor.count - begun - 4_096) <= 2
    assert abs(stepper[0x6064] - from_there - 51_200) <= 25


def test_a_rotor_of_the_lmd_that_is_held_is_locked_for_its_module(stepper):
    """hMT: the field leads no further than its bound, and 2742h tells."""
    motor = stepper.chip.motor
    stepper[0x6040] = 0
    stepper.bench.milliseconds(5)
    stepper[0x2701], stepper[0x2710] = 0x80, 40
    enable(stepper, PROFILE_POSITION)
    stepper.bench.milliseconds(20)
    assert stepper[0x2742] == 0x80
    motor.is_held = True
    stepper[0x6081], stepper[0x6083], stepper[0x6084] = 200_000, 4_000_000, 4_000_000
    stepper[0x607A] = stepper[0x6064] + 51_200
    stepper[0x6040] = 0x1F
    stepper.bench.milliseconds(250)
    assert stepper[0x2742] & 0x89 == 0x89


def test_the_lmd_gives_a_torque(stepper):
    stepper[0x6040] = 0
    stepper.bench.milliseconds(5)
    stepper[0x2701], stepper[0x2204] = 0x80, 100
    enable(stepper, PROFILE_TORQUE)
    hold(stepper, 100)
    assert abs(stepper[0x6077] - 100) <= 2
    torque = stepper.chip.motor.torque() * 1e3
    assert abs(torque / RATED_TORQUE - 0.1) < 0.003, torque


def test_the_s200_gives_the_current_that_its_text_asks_for_and_shows_it(servo):
    """T in mA in the digital current mode, I and IQ of the loops, and KPP and KVP into them."""
    motor = servo.chip.motor
    enable(servo, -126)
    motor.is_held = True
    servo.sdo[0x360E][1].raw = 1_200
    servo.bench.milliseconds(60)
    assert abs(motor.q - 1.2) < 0.03 and abs(motor.d) < 0.05, (motor.d, motor.q)
    for index in (0x3558, 0x3570):
        assert abs(servo.sdo[index][1].raw - 1_200) < 60, hex(index)
    # No current without a motor that is said to be right.
    servo.sdo[0x3900][1].raw = 0
    servo.bench.milliseconds(20)
    assert abs(motor.q) < 0.05


def test_a_turn_of_the_s200_has_65536_increments_of_an_encoder_with_10000_counts(servo):
    motor = servo.chip.motor
    begun, from_there = motor.count, servo[0x6064]
    servo[0x6081], servo[0x6083], servo[0x6084] = 655_360, 13_107_200, 13_107_200
    servo[0x607A] = from_there + 65_536
    servo[0x6040] = 0x1F
    servo.bench.milliseconds(300)
    assert abs(motor.count - begun - 10_000) <= 3
    assert abs(servo[0x6064] - from_there - 65_536) <= 20


def test_the_interrupts_of_the_lmd_are_short(stepper):
    on_the_way(stepper, 256_000, 512_000)
    interrupts_are_short(stepper.chip, 20, more=1)


def test_the_interrupts_of_the_s200_are_short(servo):
    on_the_way(servo, 100_000, 100_000)
    interrupts_are_short(servo.chip, 20)
