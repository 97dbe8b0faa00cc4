"""Segmented and block transfers: of many thousand bytes with the test device, of the drive's own values with the drive."""

import random

import canopen
import pytest
from canopen.sdo import SdoAbortedError

from conftest import NODE_ID, add
from test_sdo import LIVE, entries

#: Objects of the test device.
DOMAIN, OTHER_DOMAIN = 0x2002, 0x2013

#: Around what an expedited transfer (4 bytes), a segment (7) and a sub-block (889) hold, one whose last segment begins like the
#: frame that ends a block download (455), and many sub-blocks.
LENGTHS = [1, 2, 4, 5, 6, 7, 8, 13, 14, 15, 128, 455, 882, 888, 889, 890, 896, 1778, 1779, 5000, 20_000]

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


@pytest.fixture
def domains(start_test_device, connect):
    """The test device with a node-ID, Pre-operational."""
    network = connect(start_test_device())
    return add(network, canopen.RemoteNode(NODE_ID, canopen.ObjectDictionary()))


@pytest.mark.only("virtual", "socketcan")
@pytest.mark.parametrize("block", [False, True], ids=["segmented", "block"])
def test_what_is_written_is_read_by_both_kinds_of_transfer(domains, block):
    for length in LENGTHS:
        data = some_bytes(length)
        download(domains, DOMAIN, data, block)
        assert upload(domains, DOMAIN, False) == data, length
        assert upload(domains, DOMAIN, True) == data, length


@pytest.mark.only("virtual", "socketcan")
def test_a_download_without_a_checksum(domains):
    # An upload without one is beyond python-canopen: it expects a checksum from a server that is able to give one.
    data = some_bytes(3000)
    download(domains, DOMAIN, data, True, request_crc_support=False)
    assert upload(domains, DOMAIN, True) == data


@pytest.mark.only("virtual", "socketcan")
@pytest.mark.parametrize("size", [1, 2, 40, 126])
def test_a_client_chooses_the_size_of_the_sub_blocks(domains, monkeypatch, size):
    data = some_bytes(2000)
    download(domains, DOMAIN, data, True)
    monkeypatch.setattr(canopen.sdo.client.BlockUploadStream, "blksize", size)
    assert upload(domains, DOMAIN, True) == data


@pytest.mark.only("virtual", "socketcan")
def test_an_abandoned_transfer_changes_nothing(domains):
    download(domains, DOMAIN, b"what was there before", True)
    for block in (False, True):
        stream = domains.sdo.open(DOMAIN, mode="wb", buffering=0, size=100, block_transfer=block)
        stream.write(some_bytes(7))
        domains.sdo.abort()
        assert upload(domains, DOMAIN, True) == b"what was there before"
        # python-canopen would send the end of the transfer when it forgets the stream.
        stream._initialized, stream._done = False, True


@pytest.mark.only("virtual", "socketcan")
def test_a_wrong_checksum_changes_nothing(domains):
    download(domains, OTHER_DOMAIN, b"what was there before", True)
    stream = domains.sdo.open(OTHER_DOMAIN, mode="wb", buffering=0, size=14, block_transfer=True)
    stream.write(b"seven b")
    stream.write(b"and 7 m")
    stream._crc.process(b"what was never sent")
    with pytest.raises(SdoAbortedError, match="0x05040004"):
        stream.close()
    assert upload(domains, OTHER_DOMAIN, True) == b"what was there before"


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
