"""The scenarios of the matrix in groups that a person can read."""

from collections.abc import Iterable

GROUPS: dict[str, tuple[str, ...]] = {
    "Where the model holds": (
        *("ideal_1khz", "noisy_1khz", "paper_100hz", "jittered_22ms", "encoder", "encoder_difference"),
        *("fast_loop_1khz", "fast_loop_encoder", "fast_sine", "dither", "asymmetric", "servo", "high_stiction"),
        *("via_points", "pick_and_place", "triangle", "positioning"),
    ),
    "What changes on the way": (
        *("friction_drops", "friction_rises", "friction_triples", "warm_up", "load_step_30", "load_step_80"),
        *("payload_double", "payload_half"),
    ),
    "What is assumed wrong": (
        *("vs_half", "vs_double", "high_stiction_vs_quarter", "high_stiction_vs_fourfold"),
        *("inertia_low", "inertia_high", "torque_constant_low", "torque_constant_high"),
        *("delay_unknown", "delay_absent", "current_lag"),
    ),
    "Other joints than the model's": (
        *("lugre", "lugre_1e4", "lugre_3e3", "lugre_1e3", "elastic", "backlash", "gravity_40", "gravity_100"),
        *("elasto_plastic", "maxwell", "rolling"),
        *("friction_over_position", "friction_over_load", "friction_over_temperature"),
    ),
    "At the limits of the loop": (
        *("delay", "saturation", "standstill", "slow_stribeck", "slow_050", "slow_025", "slow_010"),
        *("steep_2", "steep_5", "steep_10", "steep_20"),
    ),
}
"""Names of scenarios by group, both in the order of the tables."""

OTHERS = "Further scenarios"
"""Group of those that are in no other."""


def group_of(name: str) -> str:
    """Return the group of a scenario."""
    return next((group for group, names in GROUPS.items() if name in names), OTHERS)


def grouped(names: Iterable[str]) -> dict[str, list[str]]:
    """Return names of scenarios by group, in the order of the tables; groups without any are left out."""
    left = list(names)
    found = {group: [name for name in members if name in left] for group, members in GROUPS.items()}
    found[OTHERS] = [name for name in left if group_of(name) == OTHERS]
    return {group: members for group, members in found.items() if members}
