"""Mutants that change nothing anybody could see, each with the reason."""

EQUIVALENT: dict[tuple[str, str, str], str] = {
    (
        "adaptive_ff.regression.known_loads.advance_loads_in_place",
        "if gravity > 0:",
        "if gravity > 1:",
    ): "gravity has two rows or none",
    (
        "adaptive_ff.regression.known_loads.load_torque",
        "if gravity > 0:",
        "if gravity > 1:",
    ): "gravity has two rows or none",
    (
        "adaptive_ff.adaptive.change_detection.attribute_change",
        "return Alarm(NOTHING, 0.0, 0.0, 0.0, 0.0, alarm.load)",
        "return Alarm(NOTHING, 1.0, 0.0, 0.0, 0.0, alarm.load)",
    ): "of an alarm without a cause nothing but the cause and the load is read",
    (
        "adaptive_ff.adaptive.change_detection.attribute_change",
        "return Alarm(NOTHING, 0.0, 0.0, 0.0, 0.0, alarm.load)",
        "return Alarm(NOTHING, 0.0, 1.0, 0.0, 0.0, alarm.load)",
    ): "of an alarm without a cause nothing but the cause and the load is read",
    (
        "adaptive_ff.adaptive.change_detection.attribute_change",
        "return Alarm(NOTHING, 0.0, 0.0, 0.0, 0.0, alarm.load)",
        "return Alarm(NOTHING, 0.0, 0.0, 1.0, 0.0, alarm.load)",
    ): "of an alarm without a cause nothing but the cause and the load is read",
    (
        "adaptive_ff.adaptive.change_detection.attribute_change",
        "return Alarm(NOTHING, 0.0, 0.0, 0.0, 0.0, alarm.load)",
        "return Alarm(NOTHING, 0.0, 0.0, 0.0, 1.0, alarm.load)",
    ): "of an alarm without a cause nothing but the cause and the load is read",
    (
        "adaptive_ff.adaptive.change_detection.attribute_change",
        "if age > SETTLING * window:",
        "if age >= SETTLING * window:",
    ): "sums of periods do not meet the limit in all digits",
    (
        "adaptive_ff.adaptive.lag_tuning.drop_stale_evidence",
        "if evidence.energy == 0.0 or (young and moved > MOVED * evidence.since + period):",
        "if evidence.energy == 0.0 or (young and moved >= MOVED * evidence.since + period):",
    ): "an estimate does not meet the limit in all digits",
    (
        "adaptive_ff.adaptive.estimator.guess_friction_in_place",
        "if guess > estimate[COULOMB] and stuck <= CLAMPED:",
        "if guess >= estimate[COULOMB] and stuck <= CLAMPED:",
    ): "a guess that is the estimate leaves it as it is",
    (
        "plant.step.step_ready_joint",
        "if -joint.backward.breakaway <= free_velocity <= joint.forward.breakaway:",
        "if -joint.backward.breakaway <= free_velocity < joint.forward.breakaway:",
    ): "at the speed of breaking away the solution for sliding is zero as well",
    (
        "adaptive_ff.adaptive.change_detection.forget_friction_in_place",
        "release_in_place(information, direction, share * mean, work[1])",
        "release_in_place(information, direction, share * mean, work[2])",
    ): "any row of the scratch but the first will do",
    (
        "adaptive_ff.adaptive.change_detection.attribute_change",
        "if surprise.product * product < 0.0:",
        "if surprise.product / product < 0.0:",
    ): "a quotient has the sign of the product, and what was noticed is not zero",
    (
        "adaptive_ff.adaptive.change_detection.attribute_change",
        "if age > longest:",
        "if age >= longest:",
    ): "sums of periods do not meet the limit in all digits",
    (
        "adaptive_ff.adaptive.change_detection.attribute_change",
        "if turned > TURNED_FOR * window:",
        "if turned >= TURNED_FOR * window:",
    ): "sums of periods do not meet the limit in all digits",
    (
        "adaptive_ff.regression.known_loads.advance_loads_in_place",
        "if loads.shape[0] == 0:",
        "if False:",
    ): "a short cut: nothing is done for no load",
    (
        "controllers.pi.feed_back",
        "if valid:",
        "if True:",
    ): "without a measurement the error is zero",
    (
        "controllers.pi.feed_back",
        "if not valid:",
        "if True:",
    ): "with a measurement the share of bridging is one",
    (
        "plant.step.step_ready_joint",
        "if free_velocity < 0.0:",
        "if free_velocity <= 0.0:",
    ): "a free velocity of zero sticks",
    (
        "adaptive_ff.adaptive.change_detection.forget_offset_in_place",
        "release_in_place(information, direction, share * (size * size), work[1])",
        "release_in_place(information, direction, share * (size * size), work[2])",
    ): "any row of the scratch but the first will do",
    (
        "adaptive_ff.adaptive.estimator.predict_torque",
        "prediction += estimate[OFFSET] * row[OFFSET + 1]",
        "prediction += estimate[OFFSET] / row[OFFSET + 1]",
    ): "the column of the offset is one",
}
