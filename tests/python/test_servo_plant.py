"""The plant of the servo against scipy, which integrates the same equations, written down here once more, with an error of its own of 1e-10.

The voltage stands still beside the stator, so in the frame of the rotor it turns with the angle. Cases are random: both kinds of motor, steppers of 50
pole pairs among them, with all that has an influence on the motion; where dry friction would hold or backlash would open and close they are none, as there
the equations have no derivative. Those have closed forms (`sim/servo-plant/tests/closed_forms.rs`).
"""

import json
import math
import random
import subprocess

import numpy
import pytest
from scipy.integrate import solve_ivp

STEP = 5e-6
CASES = 12


@pytest.fixture
def trace(request):
    program = request.config.getoption("--plant-trace")

    def run(case):
        answer = subprocess.run([program], input=json.dumps(case), capture_output=True, text=True)
        assert answer.returncode == 0, answer.stderr
        return numpy.array(json.loads(answer.stdout))

    return run


def a_case(numbers):
    three = numbers.random() < 0.5
    rotor = numbers.uniform(3e-6, 5e-5)
    inductance = numbers.uniform(2e-4, 4e-3)
    pole_pairs = numbers.choice([2, 4, 7] if three else [50, 100])
    motor = {
        "phases": "three" if three else "two",
        "pole_pairs": pole_pairs,
        "resistance": numbers.uniform(0.1, 3),
        "inductance_d": inductance,
        "inductance_q": inductance * numbers.uniform(1, 2) if three else inductance,
        "flux": numbers.uniform(0.05, 0.2) / pole_pairs,
        "detent": numbers.uniform(0, 0.02),
        "detent_periods": 24 if three else 4 * pole_pairs,
        "inertia": rotor,
        "viscous_friction": numbers.uniform(1e-6, 1e-4),
    }
    supply = {"voltage": 48, "resistance": 0.2, "capacitance": 1e-3, "chopper": 5}
    coupling = {"stiffness": numbers.uniform(5, 50), "damping": numbers.uniform(1e-4, 5e-3)}
    load = {"inertia": rotor * numbers.uniform(0.5, 5), "viscous_friction": 1e-5}
    spans = []
    for _ in range(20):
        gates = [numbers.uniform(0.3, 0.7) if three else numbers.uniform(-0.4, 0.4) for _ in range(3)]
        spans.append({"steps": numbers.choice([20, 50, 200]), "gates": gates, "load_torque": numbers.uniform(-0.1, 0.1)})
    return {
        "plant": {
            "motor": motor,
            "load": load,
            "coupling": numbers.choice([None, coupling]),
            "stage": {"dead_time": 0, "period": 5e-5, "ripple": 0.1},
            "supply": supply,
        },
        "initial": [numbers.uniform(-1, 1), numbers.uniform(-30, 30)],
        "spans": spans,
    }


def vector(motor, gates):
    """What the gates are beside the stator, as a share of the bus."""
    a, b, c = gates
    if motor["phases"] == "two":
        return a, b
    return (2 * a - b - c) / 3, (b - c) / math.sqrt(3)


def slopes(case, span):
    plant = case["plant"]
    motor, load, coupling, supply = (plant[name] for name in ("motor", "load", "coupling", "supply"))
    pairs, flux, resistance = motor["pole_pairs"], motor["flux"], motor["resistance"]
    ld, lq = motor["inductance_d"], motor["inductance_q"]
    half = {"two": 1, "three": 1.5}[motor["phases"]]
    alpha, beta = vector(motor, span["gates"])

    def slope(_, state):
        d, q, angle, velocity, load_angle, load_velocity, bus = state
        speed = pairs * velocity
        cosine, sine = math.cos(pairs * angle), math.sin(pairs * angle)
        vd, vq = bus * (alpha * cosine + beta * sine), bus * (beta * cosine - alpha * sine)
        torque = half * pairs * (flux + (ld - lq) * d) * q
        torque -= motor["detent"] * math.sin(motor["detent_periods"] * angle)
        friction = motor["viscous_friction"] * velocity
        load_friction = load["viscous_friction"] * load_velocity
        if coupling is None:
            both = torque - friction - load_friction - span["load_torque"]
            acceleration = load_acceleration = both / (motor["inertia"] + load["inertia"])
        else:
            held = coupling["stiffness"] * (angle - load_angle) + coupling["damping"] * (velocity - load_velocity)
            # The damper does not pull it off the stop on which the spring presses.
            if held * (angle - load_angle) < 0:
                held = 0
            acceleration = (torque - friction - held) / motor["inertia"]
            load_acceleration = (held - load_friction - span["load_torque"]) / load["inertia"]
        feed = max(0, supply["voltage"] - bus) / supply["resistance"]
        return [
            (vd - resistance * d + speed * lq * q) / ld,
            (vq - resistance * q - speed * (ld * d + flux)) / lq,
            velocity,
            acceleration,
            load_velocity,
            load_acceleration,
            (feed - half * (vd * d + vq * q) / bus) / supply["capacitance"],
        ]

    return slope


def integrate(case):
    angle, velocity = case["initial"]
    state = [0, 0, angle, velocity, angle, velocity, case["plant"]["supply"]["voltage"]]
    samples, time = [], 0
    for span in case["spans"]:
        end = time + span["steps"] * STEP
        solved = solve_ivp(slopes(case, span), (time, end), state, method="DOP853", rtol=1e-10, atol=1e-12)
        assert solved.success
        state, time = solved.y[:, -1], end
        d, q, angle, velocity, load_angle, _, bus = state
        samples.append([time, d, q, angle, velocity, load_angle, bus])
    return numpy.array(samples)


@pytest.mark.only("virtual")
@pytest.mark.parametrize("seed", range(CASES))
def test_the_plant_solves_its_equations(trace, seed):
    case = a_case(random.Random(seed))
    ours, theirs = trace(case), integrate(case)
    # A step is of second order: 5 µs beside time constants of 100 µs and more.
    scale = numpy.abs(theirs).max(axis=0)
    away = numpy.abs(ours - theirs).max(axis=0) / scale
    assert away[0] < 1e-12
    assert (away[1:] < [1e-3, 1e-3, 2e-4, 4e-4, 2e-4, 2e-5]).all(), away
