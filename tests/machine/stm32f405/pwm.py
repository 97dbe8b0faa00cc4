"""TIM1 that counts up and down (RM0090, 17.3.3 to 17.3.15): three half bridges with dead time, or four inputs of a driver that has its own, and the moment in which the
converters begin.

What changes acts at the next update event, or it is a breach: preload is asked for. Where an odd RCR puts the update events the manual and its
sisters tell differently, so a program must not rest on it: `odd_updates_at_top`."""

from collections import namedtuple

from .adc import TIM1_CC4, TIM1_TRGO
from .clock import NEVER

CEN, URS, DIR, CMS, ARPE = 1, 4, 1 << 4, 3 << 5, 1 << 7
MOE, OSSR, OSSI = 1 << 15, 1 << 11, 1 << 10
UIF, CC4IF, CC4E, CC4P = 1, 1 << 4, 1 << 12, 1 << 13
MMS_UPDATE, MMS_OC4REF = 2, 7

#: Channel of each pin, and whether it is the complementary output; their alternate function is 1.
OUTPUTS = {
    "PA8": (1, False), "PA9": (2, False), "PA10": (3, False), "PA7": (1, True), "PB0": (2, True), "PB1": (3, True),
    "PB13": (1, True), "PB14": (2, True), "PB15": (3, True), "PA11": (4, False),
}  # fmt: skip

#: An update event: its moment, whether it was at the top (the reload value) of the counter, and what acts from then on.
Update = namedtuple("Update", "time at_top reload compares")


class Centre:
    """The counter of TIM1 while CMS is set."""

    #: Whether an odd RCR that was there before the start means update events at the top.
    odd_updates_at_top = False

    def __init__(self, tim1):
        self.tim1, self.chip = tim1, tim1.chip
        #: Update events, for who judges them. What plays the motor is told at each of them, and when the outputs go on or off.
        self.log, self.on_change = [], lambda: None
        self.reset()

    def reset(self):
        #: When the counter came to 0 first, or None while it stands; the end of the half that it is in, and which half that is.
        self.begin, self.half_at, self.is_up = None, NEVER, True
        self.edge_at, self.left = NEVER, 0
        self.reload, self.compares = 0, (0, 0, 0, 0)

    # What it counts.

    def take_preload(self):
        """By an update event, or UG."""
        tim1 = self.tim1
        self.left = tim1["RCR"] & 0xFF
        if self.begin is not None and tim1["ARR"] != self.reload:
            tim1.breach("ARR changes while the counter runs up and down, which is not modelled")
        self.reload, self.compares = tim1["ARR"], tuple(tim1[f"CCR{i}"] for i in (1, 2, 3, 4))

    def start(self, now):
        tim1 = self.tim1
        self.check()
        # What UG has loaded for a train is none.
        tim1.log.clear()
        if (tim1["ARR"], tim1["RCR"] & 0xFF) != (self.reload, self.left):
            tim1.breach("counts up and down with ARR or RCR that no update event has taken")
        if self.odd_updates_at_top and self.left & 1:
            self.left -= 1
        self.turn_to(now, True)
        self.begin = now
        self.on_change()

    def stop(self):
        self.begin, self.half_at, self.edge_at = None, NEVER, NEVER

    def turn_to(self, at, is_up):
        """The counter is at one of its ends."""
        self.is_up, self.half_at = is_up, at + self.reload
        compare = self.compares[3]
        self.edge_at = at + (compare if is_up else self.reload - compare) if self.mode(4) and 0 < compare < self.reload else NEVER

    def count(self, now):
        left = self.half_at - now
        return self.reload - left if self.is_up else left

    def next_event(self):
        return self.half_at if self.half_at < self.edge_at else self.edge_at

    def event(self):
        at = self.next_event()
        if at == self.edge_at:
            return self.compare_event(at)
        self.turn_to(at, not self.is_up)
        if self.left:
            self.left -= 1
            return
        self.update(at)
        # What has just been taken says when the fourth channel has its edge.
        self.turn_to(at, self.is_up)

    def update(self, at):
        tim1 = self.tim1
        self.take_preload()
        tim1["SR"] |= UIF
        self.log.append(Update(at, not self.is_up, self.reload, self.compares[:3]))
        self.on_change()
        if tim1["CR2"] >> 4 & 7 == MMS_UPDATE:
            self.chip.adc.trigger(TIM1_TRGO, True, at)

    def compare_event(self, at):
        """The signal of the fourth channel rises or falls."""
        tim1, self.edge_at = self.tim1, NEVER
        # Mode 1 is active below the compare value.
        rises = self.is_up == (self.mode(4) == 7)
        if tim1["CR1"] >> 5 & (2 if self.is_up else 1):
            tim1["SR"] |= CC4IF
        if tim1["CR2"] >> 4 & 7 == MMS_OC4REF:
            self.chip.adc.trigger(TIM1_TRGO, rises, at)
        if tim1["CCER"] & CC4E:
            self.chip.adc.trigger(TIM1_CC4, rises != bool(tim1["CCER"] & CC4P), at)

    # What is set.

    def mode(self, channel):
        register = self.tim1["CCMR1" if channel < 3 else "CCMR2"]
        return register >> (4 if channel & 1 else 12) & 7

    def check(self):
        """Before the start."""
        tim1 = self.tim1
        if not tim1["CR1"] & ARPE:
            tim1.breach("counts up and down without ARPE, which is not modelled")
        if not tim1["ARR"] or tim1["PSC"]:
            tim1.breach(f"counts up and down with ARR {tim1['ARR']} and PSC {tim1['PSC']}, which is not modelled")
        for channel in (1, 2, 3, 4):
            if not tim1["CCER"] >> 4 * (channel - 1) & 5:
                continue
            preload = tim1["CCMR1" if channel < 3 else "CCMR2"] >> (3 if channel & 1 else 11) & 1
            if self.mode(channel) not in (6, 7) or not preload:
                tim1.breach(f"channel {channel} is on and not in a PWM mode with preload")
        self.check_outputs()

    def check_outputs(self):
        tim1 = self.tim1
        enabled = {
            (channel, complementary)
            for channel in range(1, 5 if self.are_four() else 4)
            for complementary in (False, True)
            if tim1["CCER"] >> 4 * (channel - 1) & (4 if complementary else 1)
        }
        pins = [output for pin, output in OUTPUTS.items() if self.chip.gpio[pin[1]].function(int(pin[2:])) == 1]
        for channel, complementary in enabled:
            name = f"{channel}N" if complementary else f"{channel}"
            if pins.count((channel, complementary)) != 1:
                tim1.breach(f"output {name} is on and has not one pin")
            if (channel, not complementary) in enabled and not self.dead_time():
                tim1.breach(f"output {name} and its complement are on without dead time")

    def are_four(self):
        """Whether the channels drive four half bridges that have dead times of their own. Else the fourth needs no pin to start the converters."""
        return self.tim1["CCER"] & 0x1555 == 0x1111

    def dead_time(self):
        """Clocks between one transistor of a half bridge and the other (BDTR, DTG)."""
        dtg = self.tim1["BDTR"] & 0xFF
        step = 1 << (self.tim1["CR1"] >> 8 & 3)
        if dtg < 0x80:
            return dtg * step
        if dtg < 0xC0:
            return (64 + (dtg & 0x3F)) * 2 * step
        return (32 + (dtg & 0x1F)) * (8 if dtg < 0xE0 else 16) * step

    # What leaves.

    def level(self, pin):
        """The level that the timer gives a pin now; None where it does not drive it."""
        channel, complementary = OUTPUTS[pin]
        tim1 = self.tim1
        enables, bdtr = tim1["CCER"] >> 4 * (channel - 1) & 15, tim1["BDTR"]
        if self.chip.gpio[pin[1]].function(int(pin[2:])) != 1:
            return None
        is_on, is_inverted = enables >> (2 if complementary else 0) & 1, enables >> (3 if complementary else 1) & 1
        if not bdtr & MOE:
            return 0 if bdtr & OSSI and enables & 5 else None
        if not is_on:
            return is_inverted if bdtr & OSSR and enables & 5 else None
        return self.is_active(channel, complementary, bool(enables & 1 and enables & 4)) ^ is_inverted

    def is_active(self, channel, complementary, are_both):
        """Whether a transistor is on. The signal rises in the middle of the counter's way down and falls in that of its way up; with both outputs on
        each waits for the dead time before it rises."""
        if self.begin is None:
            return 0
        period, share = 2 * self.reload, 2 * min(self.compares[channel - 1], self.reload)
        # Where the signal rises, from the moment in which the counter was 0.
        rises, length = -share // 2, share
        if complementary != (self.mode(channel) == 7):
            rises, length = share // 2, period - share
        if length in (0, period):
            return int(length > 0)
        at = (self.chip.now() - self.zero() - rises) % period
        return int((self.dead_time() if are_both else 0) <= at < length)

    def zero(self):
        """When the counter was 0 last, or will be next."""
        return self.half_at - self.reload if self.is_up else self.half_at

    def duties(self):
        """The share of the time in which each upper transistor is to be on, or None while the outputs are off: three with their complements, or four."""
        tim1 = self.tim1
        number = 4 if self.are_four() else 3
        if self.begin is None or not tim1["BDTR"] & MOE or number == 3 and tim1["CCER"] & 0x555 != 0x555:
            return None
        shares = [min(compare, self.reload) / self.reload for compare in self.compares[:number]]
        return tuple(1 - share if self.mode(i + 1) == 7 else share for i, share in enumerate(shares))
