"""SDO: every object of the electronic data sheet, and the abort code of every refusal."""

import pytest
from canopen.objectdictionary import ODVariable, datatypes
from canopen.sdo import SdoAbortedError

from conftest import SDO_TIME_OUT

#: Node-ID and bit rate in use.
NODE_ID_AND_BIT_RATE = 0x5FF0

#: An error that stands shows in it.
LIVE = {0x1001}

#: Every test begins with a write to it.
LIVE |= {SDO_TIME_OUT}


def entries(dictionary):
    """Every readable entry of the dictionary; below 1000h are data types, not objects."""
    for thing in [thing for index, thing in dictionary.items() if index >= 0x1000]:
        for entry in [thing] if isinstance(thing, ODVariable) else thing.subindices.values():
            # The history of errors is empty.
            if entry.access_type != "wo" and (entry.index, entry.subindex > 0) != (0x1003, True):
                yield entry


def aborts(code):
    return pytest.raises(SdoAbortedError, match=f"Code 0x{code:08X}")


def test_the_device_type_is_a_drive_with_a_stepper_motor(node):
    assert node.sdo[0x1000].raw == 0x0004_0192


def test_a_string_comes_in_segments(node):
    assert node.sdo[0x1008].raw == "Axis402 CiA 402 drive"


@pytest.mark.everywhere
def test_every_entry_has_the_length_and_the_default_of_the_data_sheet(node):
    for entry in entries(node.object_dictionary):
        data = node.sdo.upload(entry.index, entry.subindex)
        name = f"{entry.index:04X}h:{entry.subindex} {entry.name}"
        if entry.data_type in datatypes.NUMBER_TYPES:
            assert len(data) * 8 == len(entry), name
        # A DOMAIN has no default: it begins empty. Nor has what the drive finds by itself.
        default = b"" if entry.data_type == datatypes.DOMAIN else entry.default
        if entry.index not in LIVE and default is not None:
            assert entry.decode_raw(data) == default, name


def test_the_node_id_can_be_read_where_it_is_set(node):
    assert node.sdo[NODE_ID_AND_BIT_RATE][1].raw == node.id


def test_what_is_written_is_read(node):
    for index, value in [(0x607A, -123_456), (0x6081, 54_321), (0x6083, 1), (0x6068, 65_535), (0x605A, 6)]:
        node.sdo[index].raw = value
        assert node.sdo[index].raw == value


@pytest.mark.parametrize(
    ("index", "subindex", "code"),
    [
        (0x2FFF, 0, 0x06020000),  # no such object
        (0x1018, 9, 0x06090011),  # no such sub-index
        (0x1003, 1, 0x08000024),  # no error yet, so no data
    ],
)
def test_an_upload_is_refused(node, index, subindex, code):
    with aborts(code):
        node.sdo.upload(index, subindex)


@pytest.mark.parametrize(
    ("index", "subindex", "data", "code"),
    [
        (0x2FFF, 0, "00", 0x06020000),  # no such object
        (0x1000, 0, "00 00 00 00", 0x06010002),  # read only
        (0x6041, 0, "00 00", 0x06010002),  # read only
        (0x1017, 0, "00", 0x06070013),  # too short
        (0x1017, 0, "00 00 00 00", 0x06070012),  # too long
        (0x6083, 0, "00 00 00 00", 0x06090032),  # below the limit
        (0x2040, 1, "11 27", 0x06090031),  # above the limit
        (0x6060, 0, "0A", 0x06090030),  # a mode that is not there
    ],
)
def test_a_download_is_refused(node, index, subindex, data, code):
    with aborts(code):
        node.sdo.download(index, subindex, bytes.fromhex(data))


def test_the_drive_serves_on_after_a_refusal(node):
    for _ in range(20):
        with aborts(0x06020000):
            node.sdo.upload(0x2FFF, 0)
        assert node.sdo[0x1000].raw == 0x0004_0192
