"""Whether the 95 % intervals of ``identify`` hold the truth, on synthetic logs.

Of each drawn joint there are two records along different motions; about half of the joints have the terms of the
identified models, the others have physics that these lack. ``repeats`` says whether both estimates are apart by no more
than the halves of their intervals between them.
"""

import math
import time
from typing import Any

from adaptive_ff import InputError
from adaptive_ff.identify.identification import identify_log
from adaptive_ff.identify.result import UNUSABLE
from adaptive_ff.logs.log import Log
from adaptive_ff.studies.study import Found
from benchmarks.cases.logs.drawn_logs import TERMS, driven_case, make_case
from benchmarks.suite import seeded

NAMES = ("inertia", "coulomb", "viscous")

Figures = dict[str, list[float]]


def examine(log: Log, truth: dict[str, float], **given: Any) -> Figures:
    """Identify a log.

    For each parameter the ``error`` over its true value, ``width`` of half the interval over it, and ``inside``: one
    where the interval holds the truth, else zero; ``seconds`` of the identification; and ``unusable``, one where the
    log is refused or said to be not usable.
    """
    begin = time.perf_counter()
    try:
        found = identify_log(log, **given)
    except InputError:
        return {"unusable": [1.0]}
    figures = {"seconds": [time.perf_counter() - begin], "unusable": [float(found.grade == UNUSABLE)]}
    for name in NAMES:
        if name in found.parameters:
            one, true = found.parameters[name], truth[name]
            figures[f"{name}_error"] = [one.value / true - 1.0]
            figures[f"{name}_width"] = [0.5 * (one.upper - one.lower) / true]
            figures[f"{name}_inside"] = [float(one.lower <= true <= one.upper)]
    return figures


def repetition(first: Figures, second: Figures) -> Figures:
    """Return ``repeats`` of each parameter that both records of a joint have."""
    found = {}
    for name in NAMES:
        if f"{name}_error" in first and f"{name}_error" in second:
            apart = abs(first[f"{name}_error"][0] - second[f"{name}_error"][0])
            allowed = math.hypot(first[f"{name}_width"][0], second[f"{name}_width"][0])
            found[f"{name}_repeats"] = [float(apart <= allowed)]
    return found


def run_drawn(seed: int, controllers: list[str]) -> Found:
    """Identify both records of a drawn joint."""
    cases = [make_case(seed, record=record) for record in (0, 1)]
    both = [examine(case.log, case.truth) for case in cases]
    figures = {name: [value for one in both for value in one.get(name, [])] for name in both[0] | both[1]}
    figures |= repetition(*both)
    row = "terms of the model" if cases[0].kind in TERMS else "other physics"
    return {"": {"row": row}, **dict.fromkeys(controllers, figures)}


def run_tachometer(seed: int, controllers: list[str]) -> Found:
    """Identify the log of a drawn joint with the terms of the models, whose velocity is measured with noise."""
    case = make_case(2 * seed, tachometer=True)
    return {"": {"row": "with a noisy tachometer"}, **dict.fromkeys(controllers, examine(case.log, case.truth))}


def run_driven(seed: int, controllers: list[str]) -> Found:
    """Identify the log of a joint that sticks under PI alone."""
    case = driven_case(seed)
    figures = examine(case.log, case.truth, torque_delay=case.delay)
    return {"": {"row": f"under PI alone, {case.kind}"}, **dict.fromkeys(controllers, figures)}


drawn, driven = seeded(run_drawn, {"drawn": ()}, first=10_000), seeded(run_driven, {"driven": ()})
tachometer = seeded(run_tachometer, {"tachometer": ()}, first=10_000)
