"""1010h with the power cut at operations of the flash: after it the drive has all of the old parameters, or all of the new ones."""

import pytest
from conftest import NODE_ID
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
    drive.chip.flash.programs_until_cut = operation
    answered = save(drive.bench)
    assert answered != drive.chip.is_off
    values = after_power_on(drive)
    assert values in (OLD, NEW)
    assert values == NEW or not answered
    # The store works on.
    drive[0x6081], drive[0x6083] = NEW
    assert save(drive.bench)
    assert after_power_on(drive) == NEW
