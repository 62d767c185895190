"""The verdict on a log in words: what it determines, and what it does not."""

from adaptive_ff.identify.alternatives.held_out_error import WORSE, block_squares, is_larger
from adaptive_ff.identify.reported import interval_words
from adaptive_ff.identify.result import LogIdentification
from adaptive_ff.identify.terms import (
    ASYMMETRY,
    BENT,
    DAMPING,
    GRAVITY,
    LAG,
    LONG_SATURATION,
    PATH,
    SATURATION,
    SATURATIONS,
    SLOW_SATURATION,
    SQUARE_STICTION,
    STICTION,
    is_mapped,
    mapped_word,
)
from adaptive_ff.identify.units import is_linear
from adaptive_ff.identify.words.map_words import map_words

WELL, POORLY = 0.1, 0.4
"""Relative errors of the torque up to which the model is said to explain it, and from which it is said not to."""

CLEARLY = 1.1
"""Torque at rest over Coulomb friction from which on it tells of stiction: its largest value has noise, and what begins
to move the joint, some per cent."""

UNSUITED = 0.5
"""Relative error from which a model does not suit, so that its parameters are none of the joint."""


def verdict(found: LogIdentification) -> list[str]:
    """Return what a log determines and what it does not, a sentence each."""
    sentences = [_of_fit(found)]
    if found.validation is not None:
        sentences.append(_of_validation(found))
    else:
        sentences.append("Nothing was held out: how well the model says other torques is not known.")
    known = [name for name, reported in found.parameters.items() if reported.is_known]
    if found.fit.relative_error > UNSUITED:
        sentences.append(
            f"The model does not suit: more than {100.0 * UNSUITED:g} % of the torque are left, so its parameters may "
            "not be those of the joint, whatever their intervals say."
        )
    sentences.append(
        f"Identifiable from the log: {_listed(known)}." if known else "No parameter is identifiable by itself."
    )
    sentences += _of_confounding(found) + _of_lag(found) + _of_path(found)
    sentences += _of_missing(found) + _of_asymmetry(found)
    sentences += map_words(found.position_map, found.map_asked, found.units)
    sentences.append(found.curve.remark[0].upper() + found.curve.remark[1:] + ".")
    return sentences


def _of_fit(found: LogIdentification) -> str:
    error = found.fit.relative_error
    word = "explain" if error <= WELL else "explain most of" if error <= POORLY else "do not explain"
    subject = "Inertia, gravity and friction" if GRAVITY[0] in found.selection.chosen.terms else "Inertia and friction"
    sentence = (
        f"{subject} {word} the torque: {100.0 * error:.3g} % of it are left in a band of {found.bandwidth:.3g} Hz."
    )
    if error > WELL:
        others = (
            "other axes, elasticity, ripple" if subject.count("gravity") else "gravity, other axes, elasticity, ripple"
        )
        sentence += (
            f" This is no lumped joint with one inertia, its friction changes along the log (heat), or not only "
            f"friction acts on it ({others}); intervals do not cover that."
        )
        if not is_linear(found.units) and not any(GRAVITY[0] in terms for terms in found.selection.models):
            sentence += " Gravity was not among the terms tried: that takes a position, and --model auto or gravity."
    return sentence


def _of_validation(found: LogIdentification) -> str:
    assert found.validation is not None
    sentence = (
        f"On {found.validated_on}, which was not fitted, {100.0 * found.validation.relative_error:.3g} % are left"
    )
    if is_larger(found.fit, found.validation):
        ratio = found.validation.rms_error / found.fit.rms_error
        return f"{sentence}: {ratio:.1f} times the error of the fit{_why(found)}"
    if found.validation.relative_error > WORSE * found.fit.relative_error:
        return sentence + ", of a torque that is smaller there: the error itself is like that of the fit."
    return sentence + "."


def _why(found: LogIdentification) -> str:
    """Go on from a much larger error on what was held out with what it tells."""
    if found.other_units is not None:
        return f"; {found.other_units}."
    assert found.validation is not None
    if found.carries_over is not None and found.carries_over[1].rms_error < found.validation.rms_error:
        terms, error = found.carries_over
        return (
            f". The model of {_listed(list(terms))} leaves {100.0 * error.relative_error:.3g} % there: "
            "the terms chosen on the log do not carry over."
        )
    if found.has_other_load:
        carried = "Gravity or the offset" if GRAVITY[0] in found.selection.chosen.terms else "The offset"
        return (
            f". {carried} differs there (another load, a sensor's zero or, of gravity, a position counted from "
            "another zero); inertia and friction are the same."
        )
    if found.has_changed:
        return ", and every family of models gets worse there. Friction or inertia differs there."
    low, high = (end(block_squares(found.selection, found.fit)) ** 0.5 / found.fit.rms_error for end in (min, max))
    return (
        f"; blocks of the fitted log, each left out in turn, have {low:.1f} to {high:.1f} times that error. So "
        "friction or inertia need not differ there: the model may lack something, or has not seen such motion."
    )


def _of_confounding(found: LogIdentification) -> list[str]:
    """Say which parameters the log cannot separate from others."""
    return [
        f"{_words(name)[0].upper() + _words(name)[1:]} is confounded with {_listed(list(reported.confounded))}: the "
        f"log allows {' to '.join(interval_words(reported.estimate, 3))} {found.units[name]}."
        for name, reported in found.parameters.items()
        if reported.confounded
    ]


def _of_lag(found: LogIdentification) -> list[str]:
    """Say what the lag does to the inertia: of ``J a + f``, lagged viscous friction takes up ``-sigma tau a``."""
    lag = found.value("friction_lag")
    if lag == 0.0:
        return []
    inertia, viscous = (found.selection.chosen.values[name] for name in ("inertia", "viscous"))
    on_bristles = found.selection.bristles
    if on_bristles is None:
        otherwise, less = "Without lag", inertia - viscous * lag
    else:
        otherwise = "If only friction on bristles lags, and viscous friction does not"
        less = on_bristles.values["inertia"]
    return [
        f"Friction lags by {1e3 * lag:.3g} ms; a delay between the columns of torque and motion would look alike. "
        f"{otherwise}, inertia would be about {less:.4g} instead of {inertia:.4g} {found.units['inertia']}."
    ]


def _of_path(found: LogIdentification) -> list[str]:
    """Say that friction follows the path since a reversal, or may do so instead of lagging."""
    length, mass = found.units[PATH], found.units["inertia"]
    if PATH in found.parameters:
        path = found.parameters[PATH].estimate
        stiffness = found.selection.chosen.values["coulomb"] / path.value
        return [
            f"Friction follows the path, not the time: after a reversal it rises over {path.value:.3g} {length} "
            f"({' to '.join(interval_words(path, 3))}), as where bristles, belts or seals bend before they slide; as "
            f"bristles of the LuGre model they have a stiffness of {stiffness:.3g} {found.units['torque']}/{length}."
        ]
    bent = found.selection.bent
    if bent is None:
        return []
    return [
        f"Friction may follow the path since a reversal instead, over {bent.values[PATH]:.3g} {length}, as where "
        f"bristles bend before they slide: that says the torque as well. Inertia would be about "
        f"{bent.values['inertia']:.4g} instead of {found.selection.chosen.values['inertia']:.4g} {mass}."
    ]


def _of_missing(found: LogIdentification) -> list[str]:
    """Say what is not identifiable from the log."""
    sentences = []
    for name, reported in found.parameters.items():
        if reported.identifiable or name in (*BENT.values(), ASYMMETRY, *GRAVITY, *SATURATIONS):
            continue
        value, _, lower, upper = reported.estimate
        words, separator = _words(name), ":"
        if name == "stiction":
            value, _, lower, upper = found.selection.tried[STICTION].estimate(STICTION)
            words, separator = "stiction, which would be above Coulomb friction by", ""
        unit = found.units[name]
        apart = "" if lower <= 0.0 <= upper or upper < 0.0 else ", and it does not improve what is held out"
        end = {LAG: "none is used", "stiction": "it is taken as Coulomb friction"}.get(name, "zero is used")
        sentences.append(
            f"Not identifiable is {words}{separator} {value:.3g} {unit}, from {lower:.3g} to {upper:.3g}{apart}; {end}."
        )
    if not found.both_ways:
        sentences.append(
            "The joint moves one way only: an offset of the torque (gravity, a sensor's zero) cannot be separated from "
            "Coulomb friction and is contained in it."
        )
    for term, reason in found.selection.refused.items():
        sentences.append(f"Not identifiable is {_words(term)}: {reason}.")
    if shows_stiction(found.rest_torque, found.parameters["coulomb"].estimate.upper):
        sentences.append(
            f"At rest the torque reached {found.rest_torque:.3g} {found.units['torque']}, more than Coulomb friction: "
            "stiction is at least about that, if the joint did rest."
        )
    return sentences


def _of_asymmetry(found: LogIdentification) -> list[str]:
    reported = found.parameters.get(ASYMMETRY)
    if reported is None:
        return []
    value, lower, upper = reported.estimate.value, reported.estimate.lower, reported.estimate.upper
    unit = found.units["viscous"]
    if not reported.used:
        return [
            f"Viscous friction may be the same both ways: half the difference is {value:.3g} {unit}, from "
            f"{lower:.3g} to {upper:.3g}. Coulomb friction that differs by direction would be an offset."
        ]
    values = found.selection.chosen.values
    offset = f"{values['offset']:.3g} {found.units['offset']}"
    return [
        f"Viscous friction differs by direction: {values['viscous'] + value:.3g} forward and "
        f"{values['viscous'] - value:.3g} {unit} backward, with an offset of {offset}. Coulomb friction that differs "
        "by direction cannot be separated from the offset."
    ]


WORDS = {
    "viscous": "viscous friction",
    "coulomb": "Coulomb friction",
    STICTION: "stiction",
    SQUARE_STICTION: "the shape of stiction",
    SATURATION: "viscous friction that saturates",
    SLOW_SATURATION: "viscous friction that saturates slowly",
    LONG_SATURATION: "viscous friction that saturates over a wide range",
    ASYMMETRY: "viscous friction by direction",
    PATH: "the path over which bristles bend",
    DAMPING: "the damping of bristles",
}


def _words(name: str) -> str:
    return WORDS.get(name, mapped_word(name) if is_mapped(name) else name.replace("_", " "))


def _listed(names: list[str]) -> str:
    words = list(dict.fromkeys(_words(name) for name in names))
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} and {words[-1]}"


def shows_stiction(rest_torque: float | None, coulomb: float) -> bool:
    """Tell whether the largest torque at rest, None without a rest, is clearly more than Coulomb friction, N m."""
    return rest_torque is not None and rest_torque > CLEARLY * coulomb
