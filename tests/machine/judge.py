"""What every run is judged by: the pulses at the pins."""

from stm32f405 import HZ

#: What 20B0h asks for as the drive comes from the factory, in nanoseconds: a pulse is so long, and what follows it; the direction stands so long
#: before and after.
FACTORY = (2_500, 2_500, 5_000, 5_000)


def clocks(nanoseconds):
    return nanoseconds * HZ // 1_000_000_000


def judge_pulses(chip, times=FACTORY):
    """Widths, gaps and turns of all pulses of this life of the chip; no burst of the DMA came late."""
    tim1 = chip.tim1
    width, gap, set_up, hold = map(clocks, times)
    assert tim1.late_bursts == 0
    before = None
    for run in tim1.log:
        assert run.width >= width, run
        assert run.period - run.width >= gap, run
        if before is not None:
            end = before.begin + before.period * (before.repeat - 1) + before.width
            # A train that was cut ends earlier than its last run says.
            assert run.begin < end or run.begin - end >= (gap if run.forward == before.forward else set_up + hold), (before, run)
        before = run
