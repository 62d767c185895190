"""What was identified of friction and force over position and load, a sentence each."""

from collections.abc import Mapping

import numpy as np

from adaptive_ff.adaptive.learning.map_reading import load_sentence, position_sentence
from adaptive_ff.identify.maps.identified_map import IdentifiedMap
from adaptive_ff.identify.maps.map_columns import MapAsked


def map_words(found: IdentifiedMap | None, asked: MapAsked, units: Mapping[str, str]) -> list[str]:
    """Return how friction, and a force, depend on position and load; or that they do not, where it was asked.

    Parameters
    ----------
    found : IdentifiedMap or None
        The map; None where the model does without.
    asked : MapAsked
        What was tried.
    units : mapping of str
        Units of what is reported.
    """
    said, missing = [], []
    unit = units["velocity"].removesuffix("/s")
    if asked.periods or asked.hats:
        if found is not None and found.friction is not None:
            said.append(position_sentence(found.position, found.friction.value, found.periods, unit))
        elif not asked.found:
            missing.append("Friction over position")
        if found is not None and found.force is not None:
            force = found.force.value
            high, low = int(np.argmax(force)), int(np.argmin(force))
            ripple = (
                f", a ripple with a period of {asked.periods[0]:.4g} {unit} found in the log" if asked.found else ""
            )
            said.append(
                f"A force depends on position, beside friction: from {force[low]:.3g} {units['torque']} at "
                f"{found.position[low]:.3g} {unit} to {force[high]:.3g} at {found.position[high]:.3g} {unit}{ripple}."
            )
        else:
            missing.append("a force over position")
    if asked.load:
        if found is not None and found.load_share is not None:
            said.append(load_sentence(found.load_share.value, units["torque"]))
        else:
            missing.append("friction over load")
    if missing:
        parts = " and ".join([", ".join(missing[:-1]), missing[-1]] if len(missing) > 1 else missing)
        verb = "is" if len(missing) == 1 else "are"
        said.append(f"{parts[0].upper()}{parts[1:]} {verb} not used: held-out data gain nothing from it.")
    return said
