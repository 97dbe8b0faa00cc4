"""What hangs on the pins: an axis that the step pulses move, with its switches."""

import subprocess

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


#: The inputs as the plant has its wires: limits, home switch (at its capture channel too), index, probes.
WIRES = (("PA4", "PA0"), ("PA5", "PA1"), ("PA6", "PB11"), ("PA7",), ("PA8",), ("PA9",))
STEP_CLOCKS = 2


class SimPlant:
    """The plant of the virtual drive (`sim/examples/stepped_axis.rs`) on the pins: step and direction turn its motor, enable gives it current, the
    brake's pin opens its brake, and its switches come back, bounces included."""

    def __init__(self, chip, program, axis):
        self.chip = chip
        self.process = subprocess.Popen([str(program), str(axis)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        self.due, self.since = chip.time, chip.time
        self.pulses = []
        self.rotor = None
        #: Where the motor stood along the axis when an input changed, and to what.
        self.edges = {pins[0]: [] for pins in WIRES}
        self.watch()
        chip.with_events.append(self)

    def watch(self):
        """Hears of every pulse that leaves the pin."""
        tim1 = self.chip.tim1
        settle = tim1.settle

        def settled(now):
            run, before, pulses = tim1.run, tim1.counted, tim1.pulses
            settle(now)
            if tim1.pulses > pulses:
                self.pulses += [(run.begin + i * run.period, run.forward) for i in range(before, tim1.counted)]

        tim1.settle = settled

    def next_event(self):
        return self.due

    def event(self):
        chip = self.chip
        now = chip.time
        self.due = now + LOOK
        chip.tim1.settle(now)
        span = (now - self.since) // US
        if not span:
            return
        pulses, self.pulses = self.pulses, []
        ways = {forward for _, forward in pulses}
        assert len(ways) < 2, "pulses of both ways in 20 µs"
        begins = [min(max(0, time - self.since), span * US - 1) // STEP_CLOCKS for time, _ in pulses]
        self.since += span * US
        power, brake = int(chip.pins.level("PA2") == 0), int(chip.pins.level("PC2") == 1)
        print(span, power, brake, "-" if ways == {False} else "+", *begins, file=self.process.stdin, flush=True)
        rotor, levels = map(int, self.process.stdout.readline().split())
        self.rotor = rotor
        for i, pins in enumerate(WIRES):
            level = levels >> i & 1
            for pin in pins:
                if chip.pins.level(pin) != level:
                    chip.pins.drive(pin, level)
                    if pin == pins[0]:
                        self.edges[pin].append((rotor, level))

    def stop(self):
        self.process.stdin.close()
        assert self.process.wait(30) == 0
        self.process.stdout.close()
