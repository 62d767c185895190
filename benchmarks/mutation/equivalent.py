"""Mutants that change nothing anybody could see, each with the reason."""

EQUIVALENT: dict[tuple[str, str, str], str] = {
    (
        "plant.step.step_ready_joint",
        "if -joint.backward.breakaway <= free_velocity <= joint.forward.breakaway:",
        "if -joint.backward.breakaway <= free_velocity < joint.forward.breakaway:",
    ): "at the speed of breaking away the solution for sliding is zero as well",
    (
        "adaptive_ff.adaptive.learning.forgetting.forget_friction_in_place",
        "release_in_place(information, direction, share * mean, work[1])",
        "release_in_place(information, direction, share * mean, work[2])",
    ): "any row of the scratch but the first will do",
    (
        "adaptive_ff.regression.known_loads.advance_loads_in_place",
        "if loads.shape[0] == 0:",
        "if loads.shape[1] == 0:",
    ): "a short cut: nothing is done for no load",
    (
        "adaptive_ff.regression.known_loads.advance_loads_in_place",
        "if loads.shape[0] == 0:",
        "if False:",
    ): "a short cut: nothing is done for no load",
    (
        "plant.step.step_ready_joint",
        "if free_velocity < 0.0:",
        "if free_velocity <= 0.0:",
    ): "a free velocity of zero sticks",
    (
        "adaptive_ff.adaptive.learning.forgetting.forget_offset_in_place",
        "release_in_place(information, direction, share * (size * size), work[1])",
        "release_in_place(information, direction, share * (size * size), work[2])",
    ): "any row of the scratch but the first will do",
    (
        "adaptive_ff.adaptive.learning.prediction.predict_torque",
        "prediction += estimate[OFFSET] * row[OFFSET + 1]",
        "prediction += estimate[OFFSET] / row[OFFSET + 1]",
    ): "the column of the offset is one",
    (
        "adaptive_ff.adaptive.learning.estimator.follow_friction_map",
        "if state.friction_map.coefficients.size == 0:",
        "if False:",
    ): "a short cut: a map without coefficients is left as it is",
    (
        "adaptive_ff.adaptive.learning.estimator.learn_friction_map",
        "if state.friction_map.coefficients.size == 0:",
        "if False:",
    ): "a short cut: a map without coefficients is left as it is",
}
