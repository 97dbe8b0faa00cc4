"""The virtual drive against its data sheet (`conformance.py`)."""

import pytest
from conformance import PROCEDURES, Device

from conftest import EDS, NODE_ID, give_node_id


@pytest.mark.own_limits
@pytest.mark.parametrize("procedure", PROCEDURES, ids=lambda procedure: procedure.__name__)
def test_the_device_is_what_its_data_sheet_says(network, procedure):
    give_node_id(network)
    procedure(Device(network, NODE_ID, EDS))
