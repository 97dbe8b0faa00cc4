"""What the tests share: the image of the board, the chip that runs it, and a master on its bus.

`--image` names the ELF file of the board `stm32f405`, `--plant` the program that plays its motor; `cargo xtask board-test` builds them."""

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
    parser.addoption("--plant", default=ROOT / "target" / "debug" / "examples" / "stepped_axis", help="the plant of the virtual drive on its wires")


@pytest.fixture(scope="session")
def image(pytestconfig):
    return Image(pytestconfig.getoption("--image"))


@pytest.fixture
def start(image, monkeypatch):
    """Starts a chip with a master: `start(flash, crystal)` is the bench."""
    time = VirtualTime(monkeypatch)
    benches = []

    def start(**how):
        time.drive = Bench(Chip(image, **how))
        time.drive.connect()
        benches.append(time.drive)
        return time.drive

    yield start
    for bench in benches:
        judge_pulses(bench.chip, bench.pulse_times)


@pytest.fixture
def unconfigured(start):
    """The bench of a chip as it comes from the factory, 150 ms after power-on."""
    bench = start()
    bench.milliseconds(150)
    return bench


@pytest.fixture(scope="session")
def numbered(image):
    """The parameter sectors of a chip that has stored its node-ID."""
    with pytest.MonkeyPatch.context() as patch:
        time = VirtualTime(patch)
        time.drive = bench = Bench(Chip(image))
        bench.connect()
        bench.milliseconds(150)
        bench.give_node_id(NODE_ID, store=True)
        bench.chip.cycle_power()
    return bench.chip.parameters


@pytest.fixture
def bench(start, numbered):
    """The bench of a chip that has its node-ID, booted."""
    bench = start(flash=numbered)
    bench.chip.run(20_000_000, lambda: bench.frames)
    bench.milliseconds(5)
    return bench


@pytest.fixture
def drive(bench):
    return Drive(bench, bench.add(NODE_ID, EDS))
