"""What is listed as identifiable."""

import numpy as np
import pytest
from synthetic_logs import sines_log

from adaptive_ff.identify.fitting.term_selection import Selection
from adaptive_ff.identify.identification import identify_log
from adaptive_ff.identify.terms import SATURATIONS


@pytest.mark.parametrize("vanishes", [False, True])
def test_speed_at_which_a_term_bends_is_identifiable_only_if_the_term_is(vanishes, monkeypatch):
    """The velocity of a saturation of 0.001 N m, whose interval held zero, was listed as identifiable."""
    log, _ = sines_log(lambda position, velocity: 2.0 * np.sign(velocity) + 3.0 * np.tanh(velocity / 0.5))
    interval = Selection.interval

    def wide(selection, name):
        estimate = interval(selection, name)
        return estimate._replace(lower=-0.1) if vanishes and name in SATURATIONS else estimate

    monkeypatch.setattr(Selection, "interval", wide)
    found = identify_log(log)
    (shape,) = [name for name in SATURATIONS if name in found.selection.chosen.terms]
    known = next(sentence for sentence in found.verdict if sentence.startswith("Identifiable from the log"))
    assert found.parameters[f"{shape}_velocity"].is_known is not vanishes
    assert (f"{shape} velocity".replace("_", " ") in known) is not vanishes
    assert (shape in found.parameters[f"{shape}_velocity"].confounded) is vanishes
