"""`sim plan` against ruckig, an independent planner of time-optimal motion: the same moves take the same time.

ruckig limits the acceleration by its sign, CiA 402 by whether the speed grows or falls. So moves that begin away from the
target, or too fast to stop before it, differ by design (the reference vectors T13 and T18); they are not compared.
"""

import json
import math
import random
import subprocess

import pytest
from ruckig import InputParameter, Result, Ruckig, Trajectory

#: A tick of the step timer, in seconds.
TICK = 1 / 168e6
MOVES = 60


@pytest.fixture
def plan(request):
    program = request.config.getoption("--sim")

    def run(**limits):
        arguments = [f"--{name.replace('_', '-')}={value}" for name, value in limits.items()]
        answer = subprocess.run([program, "plan", "--json", *arguments], capture_output=True, text=True)
        if "is not built in" in answer.stderr:
            pytest.skip("limited jerk is a feature, and this program is built without it")
        assert answer.returncode == 0, answer.stderr
        return json.loads(answer.stdout)

    return run


def fastest(distance, velocity, acceleration, deceleration, jerk=math.inf, initial_velocity=0):
    """The duration of the fastest move, in seconds; the way is positive."""
    wanted = InputParameter(1)
    wanted.current_velocity = [initial_velocity]
    wanted.target_position = [distance]
    wanted.max_velocity = [velocity]
    wanted.max_acceleration = [acceleration]
    wanted.min_acceleration = [-deceleration]
    wanted.max_jerk = [jerk]
    trajectory = Trajectory(1)
    assert Ruckig(1).calculate(wanted, trajectory) in (Result.Working, Result.Finished)
    return trajectory.duration


def a_move(numbers):
    def magnitude(least, most):
        return round(math.exp(numbers.uniform(math.log(least), math.log(most))))

    acceleration = magnitude(10_000, 1_000_000)
    return {
        "distance": magnitude(10, 50_000),
        "velocity": magnitude(1_000, 200_000),
        "acceleration": acceleration,
        "deceleration": round(acceleration * numbers.uniform(0.2, 5)),
    }


def limit_jerk(numbers, move):
    """A jerk that takes between 5 ms and a second to come to the acceleration. With two accelerations ruckig gives up, or takes longer
    than need be; from rest those are compared with the closed form in the tests of the planner."""
    move["deceleration"] = move["acceleration"]
    move["jerk"] = round(move["acceleration"] / math.exp(numbers.uniform(math.log(0.005), 0)))


def assert_same(report, move, ideal, may_be_faster=False):
    late = report["duration_s"] - ideal
    # Corners fall between ticks; limits are rounded down, in the ninth digit at most.
    assert late <= 1e-8 * ideal + 8 * TICK, f"{move}: {late} s late"
    assert may_be_faster or late >= -1e-9 * ideal - TICK, f"{move}: {-late} s early"
    assert report["final_position"] == report["pulses"] == move["distance"]


@pytest.mark.only("virtual")
@pytest.mark.parametrize("jerk", [False, True])
def test_a_move_from_rest_takes_the_least_time(plan, jerk):
    numbers = random.Random(402)
    for _ in range(MOVES):
        move = a_move(numbers)
        if jerk:
            limit_jerk(numbers, move)
        assert_same(plan(**move), move, fastest(**move))


@pytest.mark.only("virtual")
@pytest.mark.parametrize("jerk", [False, True])
def test_a_move_in_motion_takes_the_least_time(plan, jerk):
    numbers = random.Random(6086)
    compared = 0
    while compared < MOVES:
        move = a_move(numbers)
        if jerk:
            limit_jerk(numbers, move)
        speed = move["initial_velocity"] = round(move["velocity"] * numbers.random())
        stop = speed / 2 * (speed / move["deceleration"] + move["deceleration"] / move.get("jerk", math.inf))
        if stop >= move["distance"]:
            continue
        # Just behind the stopping distance ruckig stops on a gentler ramp, where speeding up first is faster.
        assert_same(plan(**move), move, fastest(**move), may_be_faster=jerk)
        compared += 1


@pytest.mark.only("virtual")
def test_sin2_takes_the_time_of_the_trapezoid(plan):
    numbers = random.Random(1)
    for _ in range(10):
        move = a_move(numbers)
        assert_same(plan(**move, profile="sin2"), move, fastest(**move))
