"""The flashed image against its data sheet, by the procedures that the virtual drive passes (`tests/python/conformance.py`)."""

import pytest
from conformance import PROCEDURES, Device
from conftest import EDS, NODE_ID


@pytest.mark.parametrize("procedure", PROCEDURES, ids=lambda procedure: procedure.__name__)
def test_the_image_is_what_its_data_sheet_says(bench, procedure):
    procedure(Device(bench.network, NODE_ID, EDS))
    assert bench.chip.resets == []
    assert bench.chip.can.stats["overruns"] == 0
