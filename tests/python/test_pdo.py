"""PDOs: re-mapping by the standard procedure, and the transmission types."""

import time

import can
import pytest
from canopen.sdo import SdoAbortedError

from conftest import NODE_ID
from frames import Frames, wait_until

SYNC_DRIVEN, ON_REQUEST, EVENT_DRIVEN = 1, 253, 255

#: In the COB-ID of SYNC: the drive sends it.
PRODUCES = 1 << 30


def map_tpdo(node, number, objects, trans_type, **settings):
    """Gives a TPDO a new mapping, and the frames that it sends."""
    node.tpdo.read()
    tpdo = node.tpdo[number]
    tpdo.clear()
    for index in objects:
        tpdo.add_variable(index)
    tpdo.trans_type = trans_type
    for name, value in ({"inhibit_time": 0, "event_timer": 0} | settings).items():
        setattr(tpdo, name, value)
    tpdo.enabled = True
    tpdo.save()
    return Frames(node.network, tpdo.cob_id)


def test_the_mapping_that_is_written_is_read_back(node):
    map_tpdo(node, 2, [0x6061, 0x6041, 0x6064], EVENT_DRIVEN)
    assert node.sdo[0x1A01][0].raw == 3
    assert [node.sdo[0x1A01][sub].raw for sub in (1, 2, 3)] == [0x60610008, 0x60410010, 0x60640020]
    assert node.sdo[0x1801][1].raw & 0x8000_07FF == 0x280 + NODE_ID


def test_a_mapping_is_not_changed_while_the_pdo_is_valid(node):
    node.tpdo.read()
    assert node.tpdo[1].enabled
    with pytest.raises(SdoAbortedError):
        node.sdo[0x1A00][0].raw = 0
    assert node.sdo[0x1A00][0].raw == 1


def test_too_long_a_mapping_is_refused(node):
    with pytest.raises(SdoAbortedError, match="0x06040042"):
        map_tpdo(node, 2, [0x6064, 0x6062, 0x6041], EVENT_DRIVEN)


def test_an_object_that_cannot_be_mapped_is_refused(node):
    with pytest.raises(SdoAbortedError, match="0x06040041"):
        map_tpdo(node, 2, [0x1008], EVENT_DRIVEN)


def test_sync_drives_a_tpdo(network, node):
    frames = map_tpdo(node, 4, [0x6064, 0x6041], SYNC_DRIVEN)
    node.nmt.state = "OPERATIONAL"
    assert frames.none()
    for _ in range(5):
        network.sync.transmit()
        frame = frames.next()
        assert frame[:4] == bytes(4)
        assert int.from_bytes(frame[4:], "little") == node.sdo[0x6041].raw
    assert frames.none()


@pytest.mark.everywhere
def test_every_third_sync_drives_a_tpdo(network, node):
    frames = map_tpdo(node, 4, [0x6041], 3)
    node.nmt.state = "OPERATIONAL"
    for _ in range(3):
        network.sync.transmit()
        network.sync.transmit()
        assert frames.none()
        network.sync.transmit()
        assert len(frames.next()) == 2


def test_a_change_sends_a_tpdo(network, node):
    frames = map_tpdo(node, 1, [0x6041, 0x6083], EVENT_DRIVEN)
    node.nmt.state = "OPERATIONAL"
    # Entering Operational is an event.
    assert int.from_bytes(frames.next()[2:], "little") == node.sdo[0x6083].raw
    for acceleration in (1, 2, 12_345_678):
        node.sdo[0x6083].raw = acceleration
        frames.until(lambda frame: frame[2:] == acceleration.to_bytes(4, "little"))
    assert frames.none()


@pytest.mark.everywhere
def test_the_event_timer_repeats_a_tpdo(network, node):
    period, count = 0.05, 20
    frames = map_tpdo(node, 1, [0x6041], EVENT_DRIVEN, event_timer=int(period * 1000))
    node.nmt.state = "OPERATIONAL"
    frames.next()
    started = time.monotonic()
    for _ in range(count):
        frames.next()
    assert time.monotonic() - started > 0.8 * count * period


def test_a_remapped_rpdo_sets_its_objects(network, node):
    node.rpdo.read()
    rpdo = node.rpdo[4]
    rpdo.clear()
    rpdo.add_variable(0x6081)
    rpdo.add_variable(0x607A)
    rpdo.trans_type = EVENT_DRIVEN
    rpdo.enabled = True
    rpdo.save()
    node.nmt.state = "OPERATIONAL"
    rpdo[0x6081].raw = 12_345
    rpdo[0x607A].raw = -54_321
    rpdo.transmit()
    wait_until(lambda: node.sdo[0x6081].raw == 12_345, "6081h by RPDO")
    assert node.sdo[0x607A].raw == -54_321


def test_a_synchronous_rpdo_waits_for_sync(network, node):
    node.rpdo.read()
    rpdo = node.rpdo[4]
    rpdo.clear()
    rpdo.add_variable(0x607A)
    rpdo.trans_type = SYNC_DRIVEN
    rpdo.enabled = True
    rpdo.save()
    node.nmt.state = "OPERATIONAL"
    rpdo[0x607A].raw = 777
    rpdo.transmit()
    assert node.sdo[0x607A].raw == 0
    network.sync.transmit()
    wait_until(lambda: node.sdo[0x607A].raw == 777, "607Ah at SYNC")


@pytest.mark.everywhere
def test_a_remote_request_drives_a_tpdo(network, node):
    frames = map_tpdo(node, 1, [0x6083], ON_REQUEST, rtr_allowed=True)
    node.nmt.state = "OPERATIONAL"
    assert frames.none()
    request = can.Message(arbitration_id=0x180 + NODE_ID, is_remote_frame=True, is_extended_id=False, dlc=4)
    for acceleration in (1, 2, 12_345_678):
        node.sdo[0x6083].raw = acceleration
        network.bus.send(request)
        assert frames.next() == acceleration.to_bytes(4, "little")
    assert frames.none()


def test_a_tpdo_begins_with_its_start_value(network, node):
    node.sdo[0x1019].raw = 10
    frames = map_tpdo(node, 4, [0x6041], 2, sync_start_value=3)
    node.nmt.state = "OPERATIONAL"
    for count in (9, 10, 1, 2):
        network.sync.transmit(count)
    assert frames.none()
    # From number 3 on it is every second.
    for count in (3, 5):
        network.sync.transmit(count)
        frames.next()
        network.sync.transmit(count + 1)
        assert frames.none()


@pytest.mark.everywhere
def test_the_drive_produces_sync_and_keeps_to_it(network, node):
    period = 0.05
    syncs = Frames(network, 0x80)
    frames = map_tpdo(node, 4, [0x6041], SYNC_DRIVEN)
    node.sdo[0x1019].raw = 4
    node.sdo[0x1006].raw = int(period * 1_000_000)
    node.sdo[0x1005].raw = 0x80 | PRODUCES
    node.nmt.state = "OPERATIONAL"
    syncs.until(lambda frame: frame == b"\x04")
    started = time.monotonic()
    for count in (1, 2, 3, 4) * 4:
        assert syncs.next() == bytes([count])
        frames.next()
    assert time.monotonic() - started > 0.8 * 16 * period
    node.sdo[0x1005].raw = 0x80
    # What was sent before the answer is here.
    for _ in range(syncs.queue.qsize()):
        syncs.next()
    assert syncs.none()
