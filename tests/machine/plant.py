"""What hangs on the pins: an axis that the step pulses move, with its switches."""

from stm32f405 import US

#: Clocks between two looks at the axis.
LOOK = 20 * US


class Axis:
    """`switches`: for each pin the steps between which it is high. What a pin is wired to beside, a capture channel, comes behind a `+`: the edges
    come to both."""

    def __init__(self, chip, switches):
        self.chip, self.switches = chip, {tuple(pins.split("+")): ends for pins, ends in switches.items()}
        #: Where each pin has changed, and to what.
        self.edges = {pin: [] for pins in self.switches for pin in pins}
        self.due = chip.time
        chip.with_events.append(self)
        self.event()

    def next_event(self):
        return self.due

    def event(self):
        chip = self.chip
        self.due = chip.time + LOOK
        chip.tim1.settle(chip.time)
        position = chip.tim1.position
        for pins, (first, last) in self.switches.items():
            level = int(first <= position <= last)
            for pin in pins:
                if chip.pins.level(pin) != level:
                    chip.pins.drive(pin, level)
                    self.edges[pin].append((position, level))
