"""What the drive remembers when its power was off."""

import pytest

from conftest import EDS, NODE_ID, give_node_id

pytestmark = pytest.mark.everywhere

#: Sub-indices of 1010h and 1011h.
COMMUNICATION, APPLICATION = 2, 3


def node_id_after_restart(start, connect, tmp_path):
    """Restarts the drive with the same parameter store and asks it by LSS."""
    network = connect(start(tmp_path))
    network.lss.send_switch_state_global(network.lss.CONFIGURATION_STATE)
    node_id = network.lss.inquire_node_id()
    network.lss.send_switch_state_global(network.lss.WAITING_STATE)
    return network, node_id


def test_a_stored_node_id_survives(start, connect, tmp_path):
    bus = start(tmp_path)
    network = connect(bus)
    lss = network.lss
    lss.send_switch_state_global(lss.CONFIGURATION_STATE)
    lss.configure_node_id(NODE_ID)
    lss.store_configuration()
    network.disconnect()
    assert bus.server.stop() == 0

    network, node_id = node_id_after_restart(start, connect, tmp_path)
    assert node_id == NODE_ID
    assert network.add_node(NODE_ID, str(EDS)).sdo[0x1000].raw == 0x40192


def test_the_last_of_many_stored_node_ids_survives(start, connect, tmp_path):
    for node_id in (1, 127, 42):
        bus = start(tmp_path)
        network = connect(bus)
        network.lss.send_switch_state_global(network.lss.CONFIGURATION_STATE)
        network.lss.configure_node_id(node_id)
        network.lss.store_configuration()
        network.disconnect()
        assert bus.server.stop() == 0
    assert node_id_after_restart(start, connect, tmp_path)[1] == 42


def test_a_node_id_that_was_not_stored_is_forgotten(start, connect, tmp_path):
    bus = start(tmp_path)
    network = connect(bus)
    give_node_id(network)
    network.disconnect()
    assert bus.server.stop() == 0
    assert node_id_after_restart(start, connect, tmp_path)[1] == 255


def with_stored_node_id(start, connect, tmp_path):
    """A drive that has a node-ID, and keeps it."""
    bus = start(tmp_path)
    network = connect(bus)
    network.lss.send_switch_state_global(network.lss.CONFIGURATION_STATE)
    network.lss.configure_node_id(NODE_ID)
    network.lss.store_configuration()
    network.disconnect()
    assert bus.server.stop() == 0
    bus = start(tmp_path)
    network = connect(bus)
    return bus, network, network.add_node(NODE_ID, str(EDS))


def test_stored_parameters_survive_and_can_be_restored(start, connect, tmp_path):
    bus, network, drive = with_stored_node_id(start, connect, tmp_path)
    drive.sdo[0x6081].raw = 4321
    drive.sdo[0x1017].raw = 250
    drive.sdo[0x1801][2].raw = 1
    drive.sdo.RESPONSE_TIMEOUT = 3
    drive.store()
    drive.sdo[0x6083].raw = 77
    network.disconnect()
    assert bus.server.stop() == 0

    bus = start(tmp_path)
    network = connect(bus)
    drive = network.add_node(NODE_ID, str(EDS))
    assert drive.sdo[0x6081].raw == 4321
    assert drive.sdo[0x1017].raw == 250
    assert drive.sdo[0x1801][2].raw == 1
    assert drive.sdo[0x6083].raw == 100000
    drive.sdo.RESPONSE_TIMEOUT = 3
    drive.restore()
    assert drive.sdo[0x6081].raw == 4321
    network.disconnect()
    assert bus.server.stop() == 0

    network = connect(start(tmp_path))
    drive = network.add_node(NODE_ID, str(EDS))
    assert drive.sdo[0x6081].raw == 10000
    assert drive.sdo[0x1017].raw == 0


def test_a_new_node_id_moves_the_identifiers_of_the_data_sheet_only(start, connect, tmp_path):
    bus, network, drive = with_stored_node_id(start, connect, tmp_path)
    drive.sdo[0x1401][1].raw = 0x233
    drive.sdo.RESPONSE_TIMEOUT = 3
    drive.store()
    network.lss.send_switch_state_global(network.lss.CONFIGURATION_STATE)
    network.lss.configure_node_id(NODE_ID + 1)
    network.lss.store_configuration()
    network.disconnect()
    assert bus.server.stop() == 0

    network = connect(start(tmp_path))
    drive = network.add_node(NODE_ID + 1, str(EDS))
    assert drive.sdo[0x1400][1].raw == 0x200 + NODE_ID + 1
    assert drive.sdo[0x1401][1].raw == 0x233


def test_groups_of_parameters_are_stored_and_restored_apart(start, connect, tmp_path):
    bus, network, drive = with_stored_node_id(start, connect, tmp_path)

    def cycle_power():
        nonlocal bus, network, drive
        network.disconnect()
        assert bus.server.stop() == 0
        bus = start(tmp_path)
        network = connect(bus)
        drive = network.add_node(NODE_ID, str(EDS))
        return drive.sdo[0x1017].raw, drive.sdo[0x6081].raw

    drive.sdo[0x1017].raw = 250
    drive.sdo[0x6081].raw = 4321
    drive.store(COMMUNICATION)
    assert cycle_power() == (250, 10_000)
    drive.sdo[0x1017].raw = 500
    drive.sdo[0x6081].raw = 4321
    drive.store(APPLICATION)
    assert cycle_power() == (250, 4321)
    drive.restore(COMMUNICATION)
    assert cycle_power() == (0, 4321)
    drive.restore()
    assert cycle_power() == (0, 10_000)
