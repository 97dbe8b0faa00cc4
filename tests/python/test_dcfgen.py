"""The bus description of docs/masters.md through lely's `dcfgen`, and what it makes of it played to the drive as a CiA 302 master boots a node."""

import pathlib
import re
import shutil
import struct
import subprocess
import sys

import canopen
import pytest

from conftest import EDS, NODE_ID, ROOT, give_node_id
from frames import Frames

pytestmark = pytest.mark.only("virtual")

#: What a master is told of its nodes (CiA 302-2): device type and identity that it expects.
EXPECTED = [(0x1F84, 0x1000, 0), (0x1F85, 0x1018, 1), (0x1F86, 0x1018, 2), (0x1F87, 0x1018, 3), (0x1F88, 0x1018, 4)]


def generated(folder, changes=()):
    """Runs `dcfgen` on the description of the documentation; returns what the master expects, and the concise DCF of the drive."""
    page = (ROOT / "docs" / "masters.md").read_text()
    description = re.search(r"```yaml\n(.*?)```", page, re.S).group(1)
    for old, new in changes:
        assert old in description
        description = description.replace(old, new)
    (folder / "bus.yml").write_text(description)
    shutil.copy(EDS, folder)
    dcfgen = pathlib.Path(sys.executable).with_name("dcfgen")
    subprocess.run([dcfgen, "-r", "bus.yml"], cwd=folder, check=True, timeout=120)
    # The settings of the master itself are a concise DCF as well.
    expected = {(index, sub): int.from_bytes(data, "little") for index, sub, data in concise(folder / "master.bin")}
    return expected, concise(folder / "axis.bin")


def concise(file):
    """The entries of a concise DCF (CiA 302-3): index, sub-index, length, bytes."""
    data = file.read_bytes()
    (count,) = struct.unpack_from("<I", data)
    entries, place = [], 4
    for _ in range(count):
        index, sub, length = struct.unpack_from("<HBI", data, place)
        place += 7
        entries.append((index, sub, data[place : place + length]))
        place += length
    assert place == len(data)
    return entries


def boot(network, sdo, expected, entries):
    """Boots a node as CiA 302-2 says: identity, configuration, start. Returns the object that is not as expected, if one is."""
    for told, index, sub in EXPECTED:
        wanted = expected.get((told, NODE_ID), 0)
        if wanted and int.from_bytes(sdo.upload(index, sub), "little") != wanted:
            return index, sub
    for index, sub, data in entries:
        sdo.download(index, sub, data)
    network.send_message(0, bytes([1, NODE_ID]))
    return None


def test_the_description_of_the_documentation_configures_the_drive(network, tmp_path):
    expected, entries = generated(tmp_path)
    assert expected[0x1F87, NODE_ID] == 0x10000
    node = network.add_node(canopen.RemoteNode(NODE_ID, str(EDS)))
    give_node_id(network)
    heartbeat = Frames(network, 0x700 + NODE_ID)
    assert boot(network, node.sdo, expected, entries) is None
    while heartbeat.next() != b"\x05":
        pass
    for index, sub, data in entries:
        if sub == 0 and 0x1600 <= index < 0x1C00 and data == b"\x00":
            continue  # switched off while it is written
        if sub == 1 and index in (0x1400, 0x1800) and data[3] & 0x80:
            continue
        assert node.sdo.upload(index, sub) == data, f"{index:04X}h:{sub:02X}"
    tpdo = Frames(network, 0x180 + NODE_ID)
    network.send_message(0x80, b"")
    assert len(tpdo.next()) == 6


def test_a_drive_of_another_revision_is_not_configured(network, tmp_path):
    expected, entries = generated(tmp_path, [("0x10000", "0x20000")])
    node = network.add_node(canopen.RemoteNode(NODE_ID, str(EDS)))
    give_node_id(network)
    before = node.sdo.upload(0x60C2, 1)
    assert boot(network, node.sdo, expected, entries) == (0x1018, 3)
    assert node.sdo.upload(0x60C2, 1) == before
    assert node.sdo.upload(0x1017, 0) == bytes(2)
