"""Segmented and block transfers: of many thousand bytes, and of the drive's own values."""

import random

import canopen
import pytest
from canopen.sdo import SdoAbortedError

from conftest import NODE_ID
from frames import Frames
from test_sdo import LIVE, entries

#: A DOMAIN, and how many bytes it takes.
USER_MEMORY, ROOM = 0x2020, 20_480

#: Around what an expedited transfer (4 bytes), a segment (7) and a sub-block (889) hold, one whose last segment begins like the
#: frame that ends a block download (455), and many sub-blocks.
LENGTHS = [1, 2, 4, 5, 6, 7, 8, 13, 14, 15, 128, 455, 882, 888, 889, 890, 896, 1778, 1779, 5000, ROOM]

#: What is written to the drive.
VALUES = [(0x607A, -123_456), (0x6081, 54_321), (0x6083, 1), (0x6068, 65_535), (0x605A, 6), (0x1017, 0)]


def some_bytes(length):
    """The same bytes every time."""
    return random.Random(length).randbytes(length)


def download(node, index, data, block, **how):
    """Writes with one kind of transfer, whatever the length."""
    if not block:
        how["force_segment"] = True
    with node.sdo.open(index, mode="wb", buffering=7, size=len(data), block_transfer=block, **how) as stream:
        stream.write(data)


def upload(node, index, block, subindex=0, **how):
    """Reads with one kind of transfer."""
    with node.sdo.open(index, subindex, mode="rb", block_transfer=block, **how) as stream:
        return stream.read()


@pytest.mark.everywhere
@pytest.mark.parametrize("block", [False, True], ids=["segmented", "block"])
def test_what_is_written_is_read_by_both_kinds_of_transfer(node, block):
    for length in LENGTHS:
        data = some_bytes(length)
        download(node, USER_MEMORY, data, block)
        assert upload(node, USER_MEMORY, False) == data, length
        assert upload(node, USER_MEMORY, True) == data, length


def test_a_download_without_a_checksum(node):
    # An upload without one is beyond python-canopen: it expects a checksum from a server that is able to give one.
    data = some_bytes(3000)
    download(node, USER_MEMORY, data, True, request_crc_support=False)
    assert upload(node, USER_MEMORY, True) == data


@pytest.mark.everywhere
@pytest.mark.parametrize("size", [1, 2, 40, 126])
def test_a_client_chooses_the_size_of_the_sub_blocks(node, monkeypatch, size):
    data = some_bytes(2000)
    download(node, USER_MEMORY, data, True)
    monkeypatch.setattr(canopen.sdo.client.BlockUploadStream, "blksize", size)
    assert upload(node, USER_MEMORY, True) == data


def test_an_abandoned_transfer_changes_nothing(node):
    download(node, USER_MEMORY, b"what was there before", True)
    for block in (False, True):
        stream = node.sdo.open(USER_MEMORY, mode="wb", buffering=0, size=100, block_transfer=block)
        stream.write(some_bytes(7))
        node.sdo.abort()
        assert upload(node, USER_MEMORY, True) == b"what was there before"
        # python-canopen would send the end of the transfer when it forgets the stream.
        stream._initialized, stream._done = False, True


def test_a_wrong_checksum_changes_nothing(node):
    download(node, USER_MEMORY, b"what was there before", True)
    stream = node.sdo.open(USER_MEMORY, mode="wb", buffering=0, size=14, block_transfer=True)
    stream.write(b"seven b")
    stream.write(b"and 7 m")
    stream._crc.process(b"what was never sent")
    with pytest.raises(SdoAbortedError, match="0x05040004"):
        stream.close()
    assert upload(node, USER_MEMORY, True) == b"what was there before"


@pytest.mark.everywhere
def test_the_user_memory_outlives_a_reset_of_the_node(node):
    data = some_bytes(1000)
    download(node, USER_MEMORY, data, True)
    boot_up = Frames(node.network, 0x700 + NODE_ID)
    node.nmt.send_command(0x81)
    assert boot_up.next() == b"\x00"
    assert upload(node, USER_MEMORY, True) == data


@pytest.mark.parametrize("block", [False, True], ids=["segmented", "block"])
def test_more_than_the_user_memory_holds_is_refused(node, block):
    download(node, USER_MEMORY, b"what was there before", True)
    with pytest.raises(SdoAbortedError, match="0x06070012"):
        download(node, USER_MEMORY, bytes(ROOM + 1), block)
    assert upload(node, USER_MEMORY, True) == b"what was there before"


def test_every_value_of_the_drive_is_the_same_in_a_block(node):
    for entry in entries(node.object_dictionary):
        block = upload(node, entry.index, True, entry.subindex)
        name = f"{entry.index:04X}h:{entry.subindex} {entry.name}"
        if entry.index in LIVE:
            assert len(block) * 8 == len(entry), name
        else:
            assert block == node.sdo.upload(entry.index, entry.subindex), name


@pytest.mark.parametrize("block", [False, True], ids=["segmented", "block"])
def test_what_is_written_to_the_drive_is_read(node, block):
    for index, value in VALUES:
        entry = node.object_dictionary[index]
        download(node, index, entry.encode_raw(value), block)
        assert node.sdo[index].raw == value
        assert upload(node, index, True) == entry.encode_raw(value)


@pytest.mark.parametrize("block", [False, True], ids=["segmented", "block"])
@pytest.mark.parametrize(
    ("index", "data", "code"),
    [
        (0x1008, "41 42 43 44 45", 0x06010002),  # read only
        (0x607A, "00 00 00 00 00", 0x06070012),  # too long
        (0x607A, "00 00 00", 0x06070013),  # too short
        (0x6083, "00 00 00 00", 0x06090032),  # below the limit
        (0x2FFF, "00 00 00 00", 0x06020000),  # no such object
    ],
)
def test_the_drive_refuses_with_the_same_code_whatever_the_transfer(node, index, data, code, block):
    with pytest.raises(SdoAbortedError, match=f"0x{code:08X}"):
        download(node, index, bytes.fromhex(data), block)
    assert node.sdo[0x1000].raw == 0x0004_0192
