"""1010h with the power cut in the middle of operations of the flash, with some of its bits done:
after it the drive has all of the old parameters, or all of the new ones."""

import pytest
from conftest import EDS, NODE_ID, once
from drive import Drive
from stm32f405 import HZ

#: 6081h and 6083h as they come from the factory, and as they are to be stored.
OLD, NEW = (10_000, 100_000), (4_321, 7_777)

#: An SDO client's expedited download of "save" to 1010h:1.
SAVE = bytes.fromhex("23 10 10 01 73 61 76 65")


def save(bench):
    """Asks for it and waits until it is answered or the power is gone. Whether it was answered."""
    since = bench.chip.time
    bench.network.send_message(0x600 + NODE_ID, SAVE)
    answered = lambda: bench.sent_since(since, 0x580 + NODE_ID)
    bench.chip.run(8 * HZ, answered)
    return bool(answered())


def after_power_on(drive):
    """What the drive has behind the next power-on, which is without a breach and without a reset."""
    bench, chip = drive.bench, drive.chip
    since, resets = chip.time, len(chip.resets)
    chip.cycle_power()
    chip.run(HZ, lambda: bench.sent_since(since, 0x700 + NODE_ID))
    assert bench.sent_since(since, 0x700 + NODE_ID), "no boot-up"
    assert len(chip.resets) == resets
    return drive[0x6081], drive[0x6083]


def test_what_is_stored_is_there_after_power_on(drive):
    drive[0x6081], drive[0x6083] = NEW
    assert save(drive.bench)
    assert after_power_on(drive) == NEW


@pytest.mark.parametrize("operation", [1, 2, 30, 400, 1_500])
def test_a_power_cut_while_it_stores_loses_no_parameter(drive, operation):
    drive[0x6081], drive[0x6083] = NEW
    drive.chip.flash.operations_until_cut = operation
    answered = save(drive.bench)
    assert answered != drive.chip.is_off
    values = after_power_on(drive)
    assert values in (OLD, NEW)
    assert values == NEW or not answered
    # The store works on.
    drive[0x6081], drive[0x6083] = NEW
    assert save(drive.bench)
    assert after_power_on(drive) == NEW


@pytest.fixture(scope="module")
def full(image, booted):
    """The parameter sectors of a chip that erases one of them when it stores the next time; 6083h
    counts what it has stored."""

    def begin(start):
        bench = start.like(booted)
        drive = Drive(bench, bench.add(NODE_ID, EDS))
        for number in range(1, 20):
            drive[0x6083] = number
            before = bytes(drive.chip.engine.parameters)
            assert save(bench)
            if drive.chip.flash.erased:
                drive.chip.leave()
                return before, number
        raise AssertionError("nothing was erased")

    return once(image, begin)


@pytest.mark.parametrize("part", [0.0, 0.5])
def test_the_slowest_flash_and_the_fastest_watchdog_get_on(start, full, part):
    """A store that erases, a power cut in its middle, the start that sets it right, and another store: the watchdog's oscillator has 47 kHz."""
    parameters, number = full
    bench = start(flash=parameters)
    chip = bench.chip

    def begin():
        chip.iwdg.lsi, chip.flash.is_slow = 47_000, True
        assert chip.run(3 * HZ, lambda: bench.sent_since(since, 0x700 + NODE_ID))

    since = chip.time
    begin()
    drive = Drive(bench, bench.add(NODE_ID, EDS))
    drive[0x6083] = number
    if part:
        chip.flash.erases_until_cut, chip.flash.erased_part = 1, part
        assert not save(bench)
        since = chip.time
        chip.cycle_power()
        begin()
        drive[0x6083] = number
    assert save(bench)
    assert part or chip.flash.erased
    assert chip.resets == []


@pytest.mark.parametrize("part", [0.001, 0.9999])
def test_a_power_cut_while_it_erases_loses_no_parameter(start, full, part):
    """Few of the bits are erased by then, or most of them."""
    parameters, number = full
    bench = start(flash=parameters)
    assert bench.chip.run(HZ, lambda: bench.frames)
    drive = Drive(bench, bench.add(NODE_ID, EDS))
    drive.chip.flash.erases_until_cut, drive.chip.flash.erased_part = 1, part
    drive[0x6083] = number
    assert not save(bench)
    assert after_power_on(drive)[1] in (number - 1, number)
    drive[0x6081], drive[0x6083] = NEW
    assert save(drive.bench)
