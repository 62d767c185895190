"""Mutants that change nothing anybody could see, each with the reason."""

EQUIVALENT: dict[tuple[str, str, str], str] = {
    (
        "plant.step.step_ready_joint",
        "if -joint.backward.breakaway <= free_velocity <= joint.forward.breakaway:",
        "if -joint.backward.breakaway <= free_velocity < joint.forward.breakaway:",
    ): "at the speed of breaking away the solution for sliding is zero as well",
    (
        "plant.step.step_ready_joint",
        "if free_velocity < 0.0:",
        "if free_velocity <= 0.0:",
    ): "a free velocity of zero sticks",
}
