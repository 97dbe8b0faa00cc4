"""SDO: single objects, and block transfers of thousands of bytes."""

import random

#: Object 2020h takes so many bytes on the board; this many times is 15 kB.
USER_MEMORY, ROOM, TIMES = 0x2020, 3_840, 4


def test_objects_are_read_and_written(drive):
    assert drive[0x1000] == 0x40192
    drive[0x6081] = 4_321
    assert drive[0x6081] == 4_321


def test_15_kb_go_there_and_back_by_block_transfer(drive):
    for turn in range(TIMES):
        data = random.Random(turn).randbytes(ROOM)
        with drive.sdo.open(USER_MEMORY, mode="wb", size=ROOM, block_transfer=True) as stream:
            stream.write(data)
        with drive.sdo.open(USER_MEMORY, mode="rb", block_transfer=True) as stream:
            assert stream.read() == data
    assert drive.chip.can.stats["overruns"] == 0
