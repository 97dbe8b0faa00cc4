"""Moves: pulses at the pin, the counter TIM2 and 6064h are one and the same."""

import struct

import pytest
from conftest import NODE_ID
from drive import CYCLIC_POSITION, ENABLE, HALT, OPERATION_ENABLED, PROFILE_POSITION, QUICK_STOP
from stm32f405 import HZ, MS


def counted(drive):
    """Pulses at the pin, TIM2 and 6064h, which must agree; of these, the position."""
    actual = drive[0x6064]
    assert drive.settle() == actual
    assert drive.chip.tim2["CNT"] == drive.chip.tim1.pulses
    return actual


def stands(drive):
    before = drive.chip.tim1.pulses
    drive.bench.milliseconds(5)
    drive.settle()
    return drive.chip.tim1.pulses == before


def test_a_profile_position_move_ends_on_its_target(drive):
    drive[0x6081], drive[0x6083], drive[0x6084] = 50_000, 500_000, 500_000
    drive.enable(PROFILE_POSITION)
    for target in (5_000, -3_000):
        drive[0x607A] = target
        drive[0x6040] = ENABLE | 0x30
        drive[0x6040] = ENABLE
        drive.until(lambda: drive[0x6041] & 0x400 and drive[0x6064] == target, f"at {target}")
        assert counted(drive) == target
    assert drive.chip.tim1.pulses == 5_000 + 8_000


def test_a_velocity_is_held_to_the_clock_and_ends_by_quick_stop(drive):
    drive.turn(100_000)
    begin = drive.chip.tim1.pulses
    drive.bench.milliseconds(20)
    drive.settle()
    assert drive.chip.tim1.pulses - begin == pytest.approx(2_000, abs=200)
    # In a cruise each pulse is a whole period of the step clock behind the one before.
    assert {run.period for run in drive.chip.tim1.log[-20:]} == {HZ // 100_000}
    drive[0x6085] = 2_000_000
    drive[0x6040] = QUICK_STOP
    # 100,000 steps/s at 2,000,000 steps/s² is 50 ms.
    drive.bench.milliseconds(65)
    assert stands(drive)
    counted(drive)
    drive.until(lambda: not drive.has_power(), "no current")


def intervals(tim1, since):
    """The clocks between pulses that lie side by side, from a moment on, each kind once."""
    runs = [run for run in tim1.log if run.begin > since]
    ends = [run.begin + run.period * (run.repeat - 1) for run in runs]
    return {run.period for run in runs if run.repeat > 1} | {after.begin - end for end, after in zip(ends, runs[1:])}


@pytest.mark.parametrize(
    ("rate", "width", "burst"),
    [(10_000, 2_500, 60), (999_000, 400, 60), (1_000_000, 400, 60), (2_000_000, 200, 60), (4_900_000, 100, 80)],
)
def test_the_rates_of_the_pulse_tables_are_exact(drive, rate, width, burst):
    # The shortest run is 84 clocks.
    drive.chip.dma2.BURST, drive.chip.dma2.CONTENTION = burst, min(4, (84 - burst) // 5)
    times = (width, width, 5_000, 5_000)
    for sub, value in enumerate((255, *times), start=1):
        drive.sdo[0x20B0][sub].raw = value
    drive.bench.pulse_times = times
    drive[0x6080] = drive[0x607F] = rate
    drive.turn(rate, acceleration=40 * rate)
    begin, since = drive.settle(), drive.chip.time
    drive.bench.milliseconds(10)
    # To the pulse, and no interval is another than the two whole numbers of clocks beside the exact
    # one.
    assert abs(drive.settle() - begin - rate * (drive.chip.time - since) / HZ) <= 1
    assert intervals(drive.chip.tim1, since) <= {HZ // rate, -(-HZ // rate)}
    drive[0x6040] = HALT
    drive.until(lambda: stands(drive), "it stands")
    counted(drive)


def test_cyclic_positions_are_followed_in_step_with_sync(drive):
    drive.sdo[0x60C2][1].raw = 1
    drive.sdo[0x60C2][2].raw = -3
    drive.sdo[0x1402][2].raw = 1
    drive.sdo[0x1803][2].raw = 1
    drive.bench.network.nmt.send_command(1)
    drive.bench.milliseconds(5)
    network, bench = drive.bench.network, drive.bench
    drive[0x6060] = CYCLIC_POSITION
    begin = bench.chip.time
    answers = 0x480 + NODE_ID
    target = 0
    for cycle in range(300):
        word = 0x06 if cycle < 20 else 0x07 if cycle < 40 else ENABLE
        if 100 <= cycle < 200:
            target += 20
        network.send_message(0x400 + NODE_ID, struct.pack("<Hi", word, target))
        network.send_message(0x80, b"")
        # The next SYNC comes a millisecond behind this one, to the clock.
        bench.chip.run(begin + (cycle + 1) * MS - bench.chip.time)
    assert drive.state() == OPERATION_ENABLED
    assert counted(drive) == target == 2_000
    sent = [frame.time - begin for frame in bench.frames if frame.id == answers and frame.time >= begin]
    assert len(sent) == 300
    assert all(time % MS < MS // 2 for time in sent)
