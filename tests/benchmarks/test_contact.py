"""One contact at a time, against other solvers at equal accuracy and against bare transforms.

`make bench-peers` installs the others and compares; without them only ours is measured.
"""

import time
import tracemalloc

import numpy as np
import pytest

from tests.benchmarks.bare import bare_time, counted_transforms, shortest
from tests.benchmarks.peers import (
    CONTACT_MODULUS,
    HARDNESS,
    SOLVERS,
    Ours,
    line,
    residual,
    rough,
    sphere,
)
from tribo.contact import solve_contact

pytestmark = pytest.mark.filterwarnings("ignore")  # raised in other packages

# Residual that each solver must reach, with the loosest of its tolerances that does.
# That of other solvers is larger, as not all of them reach the smaller one on every case.
ACCURACY, OTHERS_ACCURACY = 1e-9, 2e-9
ROUNDS = 3
TOLERANCES = (1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12, 1e-13)

PATCH = 512e-6**2
LIGHT, HEAVY = (share * CONTACT_MODULUS * PATCH for share in (1.27e-3, 5.6e-3))
CASES = {
    "rough, 5 % in contact, 256²": lambda name: rough(name, 256, LIGHT),
    "rough, 20 % in contact, 64²": lambda name: rough(name, 64, HEAVY),
    "rough, 20 % in contact, 128²": lambda name: rough(name, 128, HEAVY),
    "rough, 20 % in contact, 256²": lambda name: rough(name, 256, HEAVY),
    "rough, 15 % in contact, 512²": lambda name: rough(name, 512, HEAVY),
    "rough, capped, 256²": lambda name: rough(name, 256, HEAVY, HARDNESS / 2),
    "rough, capped, 512²": lambda name: rough(name, 512, HEAVY, HARDNESS / 2),
    "Hertz sphere, 256²": lambda name: sphere(name, 256),
    "Hertz sphere, 512²": lambda name: sphere(name, 512),
    "rough line, 240²": lambda name: line(name, 240),
    "rough line, capped, 240²": lambda name: line(name, 240, HARDNESS),
}


@pytest.fixture(scope="module", params=CASES)
def case(request):
    return CASES[request.param](request.param)


@pytest.mark.benchmark(timer=time.process_time)
@pytest.mark.parametrize("kind", SOLVERS, ids=lambda kind: kind.name)
def test_contact(benchmark, case, kind, times):
    if not kind.solves(case):
        pytest.skip(f"{kind.name} does not solve this")
    try:
        solver = kind(case)
    except ModuleNotFoundError as error:
        pytest.skip(f"{error.name} is not installed")
    accuracy = ACCURACY if kind is Ours else OTHERS_ACCURACY
    for tolerance in TOLERANCES:
        pressure = solver.solve(tolerance)
        reached = residual(solver, pressure)
        if reached <= accuracy:
            break
    benchmark.group = case.name
    benchmark.pedantic(solver.solve, (tolerance,), rounds=ROUNDS)
    times.setdefault(case.name, {})[kind.name] = benchmark.stats["min"]
    cold = shortest(lambda: kind(case).solve(tolerance), ROUNDS)
    times[case.name][kind.name, "cold"] = cold
    benchmark.extra_info["residual"] = reached
    if kind is Ours:
        times[case.name] |= shares_of_transforms(solver, benchmark.stats["min"], tolerance)
    assert reached <= accuracy
    touching = np.count_nonzero(pressure) / pressure.size
    print(f"\n{case.name}, {kind.name}: residual {reached:.0e}, {touching:.1%} in contact")


def shares_of_transforms(solver, duration, tolerance):
    case = solver.case
    problem = (solver.displacement, case.separation, case.normal_load, case.hardness, tolerance)
    with counted_transforms() as transforms:
        convolutions = solve_contact(*problem).iterations
    tracemalloc.start()
    solver.solve(tolerance)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    return {
        "convolutions": convolutions,
        "transforms": duration / bare_time(transforms),
        "fields": peak / case.separation.nbytes,
    }


@pytest.fixture(scope="module")
def times():
    """Times by case, which are printed as tables of MEASURED.md at the end."""
    times = {}
    yield times
    print_peers(times)
    print("\n| contact | × bare transforms | fields of memory |\n|---|---|---|")
    for case, row in times.items():
        print(f"| {case} | {row['transforms']:.2f} | {row['fields']:.0f} |")


def print_peers(times):
    others = [kind.name for kind in SOLVERS[1:]]
    print("\n\nTimes of others in ours: again / the first time, with all that it sets up.\n")
    print(f"| contact | convolutions | ms | first ms | {' | '.join(others)} |")
    print("|---" * (4 + len(others)) + "|")
    ratios = []
    for case, row in times.items():
        ours, cold = row[Ours.name], row[Ours.name, "cold"]
        cells = [case, f"{row['convolutions']}", f"{1e3 * ours:.0f}", f"{1e3 * cold:.0f}"]
        for name in others:
            if name in row:
                pair = row[name] / ours, row[name, "cold"] / cold
                ratios += pair
                cells.append("{:.2g} / {:.2g} ×".format(*pair))
            else:
                cells.append("–")
        print(f"| {' | '.join(cells)} |")
    if ratios:
        print(f"\n{min(ratios):.2g} to {max(ratios):.2g} times as fast")
