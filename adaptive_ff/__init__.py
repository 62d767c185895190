"""Adaptive friction-compensating velocity control: identification, feedforward, comparison.

``help(adaptive_ff.NAME)`` shows one of the names below by itself.

In your own loop
    ``AdaptiveController`` identifies friction and feeds it forward; ``JointGroup`` does so for several joints.
    ``controllers.PI.design`` gives the gains of the loop.

Experiments
    ``load_scenario`` reads a ``Scenario``, ``Scenario.modified`` changes it; ``compare`` runs all its controllers and
    returns a ``Comparison`` with a ``Run`` each; ``simulate`` runs one. ``OwnController`` says what yours must have.

Guard against regressions
    ``Comparison.write`` keeps a baseline, ``assert_no_regression`` compares with it; ``regressions`` lists what got
    worse.

Recorded data
    ``read_log`` reads a ``Log``; ``identify_log`` finds a ``TorqueModel`` with intervals, a ``LogIdentification``.
    ``support_points`` and ``fit_stribeck`` fit a friction curve to drives at constant speed.

Export
    ``export_controller`` writes C99, ``run_in_c`` runs it from Python.

Bad input raises ``InputError``, a ``ValueError`` whose message names the field, its value and what is allowed.
"""

from typing import Any

import lazy_loader

from adaptive_ff.shadowed import check_not_shadowed

check_not_shadowed()

_load, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)


def __getattr__(name: str) -> Any:
    """Load a public name when it is used first."""
    if name == "__version__":
        from importlib.metadata import version  # takes longer than the rest of this file

        return version("adaptive-ff")
    return _load(name)
