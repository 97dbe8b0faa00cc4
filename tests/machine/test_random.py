"""Faults at random (`random_faults.py`): a few in each run of the tests, a thousand by its command."""

import pytest
from random_faults import KINDS, Drives, carry_out, situations

#: Each kind in each situation.
RUNS = 3 * len(KINDS)


@pytest.mark.timeout(1_200)
def test_whatever_fails_has_a_defined_reaction_and_no_pulse_is_wild(image):
    results = carry_out(situations(Drives(image).new), KINDS, range(RUNS))
    assert len(results) == RUNS
    assert [result for result in results if result[4] is None] == []
    # Each reaction is seen: a fault that does nothing would be none.
    assert {reaction for _, _, _, _, reaction, _ in results} == {"works on", "fault", "end"}
