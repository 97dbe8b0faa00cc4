"""What the tests share: the image of the board, the chip that runs it, and a master on its bus.

`--image` names the ELF file of the board `stm32f405`, `--servo-image` that of `odrive36`, `--servo-40khz-image` the same with its current loop at 40 kHz, `--stepper-image` that of
`stepper405`, `--plant` the program that plays its motor,
`--tuner` the one that measures a motor; `cargo xtask board-test` builds them."""

import pathlib

import pytest

from drive import Drive
from judge import judge_pulses
from master import Bench
from stepped import VirtualTime
from stm32f405 import Chip
from stm32f405.image import Image

ROOT = pathlib.Path(__file__).resolve().parents[2]
EDS = ROOT / "eds" / "axis402.eds"

NODE_ID = 5


def pytest_addoption(parser):
    parser.addoption("--image", default=ROOT / "target" / "xtask" / "axis402-stm32f405.elf", help="the image that is flashed")
    parser.addoption("--servo-image", default=ROOT / "target" / "xtask" / "axis402-odrive36.elf", help="the image of the servo board")
    parser.addoption("--servo-40khz-image", default=ROOT / "target" / "xtask" / "axis402-odrive36-40khz.elf", help="the same at 40 kHz")
    parser.addoption("--lmd-image", default=ROOT / "target" / "xtask" / "axis402-stepper405.lmd.elf", help="the image of the LMD on that board")
    parser.addoption("--s200-image", default=ROOT / "target" / "xtask" / "axis402-odrive36.s200.elf", help="the image of the S200 on the servo board")
    parser.addoption("--stepper-image", default=ROOT / "target" / "xtask" / "axis402-stepper405.elf", help="the image of the board with two full bridges")
    parser.addoption("--plant", default=ROOT / "target" / "debug" / "examples" / "stepped_axis", help="the plant of the virtual drive on its wires")
    parser.addoption("--tuner", default=ROOT / "target" / "debug" / "examples" / "stepped_tune", help="`axis402 tune` in virtual time")


@pytest.fixture(scope="session")
def image(pytestconfig):
    return Image(pytestconfig.getoption("--image"))


class Starts:
    """A chip on a bus with a master, for one test: from power-on (`flash`, `crystal`), or where
    another chip is."""

    def __init__(self, image, monkeypatch):
        self.image, self.time, self.benches = image, VirtualTime(monkeypatch), []

    def __call__(self, **how):
        return self.put(Bench(Chip(self.image, **how)))

    def like(self, other):
        """As far as another bench is."""
        return self.put(other.copy())

    def put(self, bench):
        self.time.drive = bench
        bench.connect()
        self.benches.append(bench)
        return bench

    def end(self):
        for bench in self.benches:
            bench.chip.leave()
        for bench in self.benches:
            judge_pulses(bench.chip, bench.pulse_times)


@pytest.fixture
def start(image, monkeypatch):
    """Starts a chip with a master: `start(flash, crystal)` is the bench."""
    starts = Starts(image, monkeypatch)
    yield starts
    starts.end()


def once(image, begin):
    """What `begin` makes of a chip from power-on, for all tests."""
    with pytest.MonkeyPatch.context() as patch:
        return begin(Starts(image, patch))


@pytest.fixture(scope="session")
def fresh(image):
    """The bench of a chip as it comes from the factory, 150 ms after power-on, from which tests
    begin."""

    def begin(start):
        bench = start()
        bench.milliseconds(150)
        return bench

    return once(image, begin)


@pytest.fixture
def unconfigured(start, fresh):
    """A chip as it comes from the factory, 150 ms after power-on."""
    return start.like(fresh)


@pytest.fixture(scope="session")
def numbered(image, fresh):
    """The parameter sectors of a chip that has stored its node-ID."""

    def begin(start):
        bench = start.like(fresh)
        bench.give_node_id(NODE_ID, store=True)
        bench.chip.cycle_power()
        bench.chip.leave()
        return bench.chip.parameters

    return once(image, begin)


@pytest.fixture(scope="session")
def booted(image, numbered):
    """The bench of a chip that has its node-ID, booted, from which tests begin."""

    def begin(start):
        bench = start(flash=numbered)
        bench.chip.run(20_000_000, lambda: bench.frames)
        bench.milliseconds(5)
        return bench

    return once(image, begin)


@pytest.fixture
def bench(start, booted):
    """The bench of a chip that has its node-ID, booted."""
    return start.like(booted)


@pytest.fixture
def drive(bench):
    return Drive(bench, bench.add(NODE_ID, EDS))
