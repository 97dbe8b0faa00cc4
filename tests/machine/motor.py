"""A motor on the bridges of a servo board, its bus, and its encoder: the equations of docs/servo.md, step by step between what the chip does."""

import math

from stm32f405 import HZ

#: Clocks of a step at most: 12.5 µs.
STEP = 2_100
#: A turn of the lines of an encoder.
LINES = ((0, 0), (1, 0), (1, 1), (0, 1))


class Level:
    """What lies at a channel of the converters: a function of the motor, by name, so that a copy of the chip has its own."""

    def __init__(self, motor, what, *arguments):
        self.motor, self.what, self.arguments = motor, what, arguments

    def __call__(self, time):
        self.motor.advance(time)
        return max(0, min(4095, round(getattr(self.motor, self.what)(*self.arguments))))


class Motor:
    """That of the data of `odrive36`: `servo_100w` with an inertia behind it, three phases on a half bridge each."""

    phases = tuple(2 * math.pi * n / 3 for n in range(3))
    #: What lies at the channels of the converters.
    channels = {6: ("bus_counts",), 10: ("sensed", 1), 11: ("sensed", 2)}

    resistance, inductance, flux, pole_pairs = 0.6, 0.8e-3, 13.33e-3, 4
    inertia, friction, counts = 19.6e-6, 5e-3, 10_000
    #: Volts of the bus, and amperes and volts of a count.
    bus, ampere, volt = 48.0, 3.3 / 4096 / 80 / 500e-6, 3.3 / 4096 * 19

    def __init__(self, chip, angle=1.0):
        self.chip, self.time = chip, chip.time
        #: Along the magnet and across it, the angle of the rotor and its velocity, and a torque that acts against positive motion.
        self.d = self.q = self.velocity = self.load = 0.0
        self.angle = angle
        self.is_held = False
        self.begin, self.count = self.encoder(), 0
        self.duties, self.most = None, 0.0
        chip.adc.levels |= {channel: Level(self, *what) for channel, what in self.channels.items()}
        chip.tim1.centre.on_change = self.changed
        #: The counts in which the index is high, in this turn and in each other.
        self.index = range(0)
        for pin in ("PB4", "PB5"):
            chip.pins.drive(pin, 0)

    def changed(self):
        self.advance(self.chip.now())
        self.duties = self.switched()

    def switched(self):
        """The share of the time in which each upper switch is on, or None while all are off."""
        return self.chip.tim1.centre.duties()

    def volts(self):
        """Of the phases."""
        mean = sum(self.duties) / 3
        return [(duty - mean) * self.bus for duty in self.duties]

    def encoder(self):
        return math.floor(self.angle * self.counts / (2 * math.pi))

    def phase(self, n):
        """The current into a phase."""
        angle = self.angle * self.pole_pairs - self.phases[n]
        return self.d * math.cos(angle) - self.q * math.sin(angle)

    def bus_counts(self):
        return self.bus / self.volt

    def sensed(self, n):
        """What the converter has of it: amplifiers are a little off."""
        return 2_048 + (-14, 9, -14)[n] + self.phase(n) / self.ampere

    def torque(self):
        """Of the current."""
        return len(self.phases) / 2 * self.pole_pairs * self.flux * self.q

    def detent(self):
        return 0.0

    def advance(self, time):
        while self.time < time:
            clocks = min(STEP, time - self.time)
            self.step(clocks / HZ)
            self.time += clocks
        self.turn_encoder()

    def step(self, seconds):
        electrical = self.angle * self.pole_pairs
        if self.duties is None:
            # The diodes take it down.
            self.d = self.q = 0.0
        else:
            volts, share = self.volts(), 2 / len(self.phases)
            d = share * sum(v * math.cos(electrical - phase) for v, phase in zip(volts, self.phases))
            q = -share * sum(v * math.sin(electrical - phase) for v, phase in zip(volts, self.phases))
            speed = self.velocity * self.pole_pairs
            back = speed * (self.inductance * self.d + self.flux)
            rise_d = (d - self.resistance * self.d + speed * self.inductance * self.q) / self.inductance
            rise_q = (q - self.resistance * self.q - back) / self.inductance
            self.d += rise_d * seconds
            self.q += rise_q * seconds
        self.most = max(self.most, math.hypot(self.d, self.q))
        if self.is_held:
            self.velocity = 0.0
            return
        drive = self.torque() - self.detent() - self.load
        change = drive * seconds / self.inertia
        brakes = self.friction * seconds / self.inertia
        velocity = self.velocity + change
        self.velocity = math.copysign(max(0.0, abs(velocity) - brakes), velocity)
        self.angle += self.velocity * seconds

    def turn_encoder(self):
        there = self.encoder() - self.begin
        while self.count != there:
            self.count += 1 if there > self.count else -1
            for pin, level in zip(("PB4", "PB5"), LINES[self.count % 4]):
                if self.chip.pins.level(pin) != level:
                    self.chip.pins.drive(pin, level)
            if self.index:
                index = (self.count - self.index.start) % self.counts < len(self.index)
                if self.chip.pins.level("PC9") != index:
                    self.chip.pins.drive("PC9", int(index))


class Stepper(Motor):
    """That of the data of `stepper405`: `nema17` with the inertia of its rotor behind it, two phases on a full bridge each, behind a driver."""

    phases = (0.0, math.pi / 2)
    channels = {10: ("bus_counts",), 0: ("sensed", 0), 1: ("sensed", 1)}
    resistance, inductance, flux, pole_pairs = 1.65, 3.2e-3, 3.66e-3, 50
    inertia, friction, counts = 10.8e-6, 4e-3, 4_096
    bus, ampere, volt = 24.0, 3.3 / 4096 / 20 / 10e-3, 3.3 / 4096 * 16

    def detent(self):
        return 0.015 * math.sin(200 * self.angle)

    def switched(self):
        """Without a pulse the inputs of the driver are low, and the lower switches on."""
        if not self.chip.driver.is_on:
            return None
        return self.chip.tim1.centre.duties() or (0.0,) * 4

    def volts(self):
        plus_a, minus_a, plus_b, minus_b = self.duties
        return [(plus_a - minus_a) * self.bus, (plus_b - minus_b) * self.bus]
