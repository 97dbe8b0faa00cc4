"""A master that has a serial CAN adapter: LSS, a power cycle, single objects, a block transfer and
a move, by python-canopen over SLCAN."""

import random

import can.interfaces.slcan
import pytest
from adapter import Adapter
from conftest import EDS, NODE_ID
from drive import ENABLE, PROFILE_POSITION, Drive
from frames import Frames
from judge import judge_pulses
from stepped import VirtualTime
from stm32f405 import Chip


@pytest.fixture
def bench(image, monkeypatch):
    time = VirtualTime(monkeypatch)
    time.drive = bench = Adapter(Chip(image))
    monkeypatch.setattr(can.interfaces.slcan.serial, "serial_for_url", lambda *_, **__: bench.serial)
    bench.connect_by(can.interfaces.slcan.slcanBus("adapter", bitrate=1_000_000, sleep_after_open=0))
    bench.milliseconds(150)
    yield bench
    bench.chip.leave()
    judge_pulses(bench.chip, bench.pulse_times)
    bench.slcan.shutdown()


def test_from_the_first_start_over_a_power_cycle_to_a_move(bench):
    assert (bench.is_open, bench.bit_rate) == (True, "8")
    lss = bench.network.lss
    lss.RESPONSE_TIMEOUT = 0.02
    found, words = lss.fast_scan()
    assert found and words[:3] == [0, 0x402, 0x10000]
    bench.give_node_id(NODE_ID, store=True)
    boot_up = Frames(bench.network, 0x700 + NODE_ID)
    bench.chip.cycle_power()
    assert boot_up.next() == b"\x00"
    drive = Drive(bench, bench.add(NODE_ID, EDS))
    assert drive[0x1000] == 0x40192
    data = random.Random(1).randbytes(2_000)
    with drive.sdo.open(0x2020, mode="wb", size=len(data), block_transfer=True) as stream:
        stream.write(data)
    with drive.sdo.open(0x2020, mode="rb", block_transfer=True) as stream:
        assert stream.read() == data
    drive.enable(PROFILE_POSITION)
    drive[0x607A] = 500
    drive[0x6040] = ENABLE | 0x30
    drive.until(lambda: drive[0x6041] & 0x400 and drive[0x6064] == 500, "there")
    assert drive.settle() == 500
