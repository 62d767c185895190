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
        "return Alarm(NOTHING, 0.0, 0.0, 0.0, 0.0)",
        "return Alarm(NOTHING, 1.0, 0.0, 0.0, 0.0)",
    ): "of an alarm without a cause nothing but the cause is read",
    (
        "adaptive_ff.adaptive.change_detection.attribute_change",
        "return Alarm(NOTHING, 0.0, 0.0, 0.0, 0.0)",
        "return Alarm(NOTHING, 0.0, 1.0, 0.0, 0.0)",
    ): "of an alarm without a cause nothing but the cause is read",
    (
        "adaptive_ff.adaptive.change_detection.attribute_change",
        "return Alarm(NOTHING, 0.0, 0.0, 0.0, 0.0)",
        "return Alarm(NOTHING, 0.0, 0.0, 1.0, 0.0)",
    ): "of an alarm without a cause nothing but the cause is read",
    (
        "adaptive_ff.adaptive.change_detection.attribute_change",
        "return Alarm(NOTHING, 0.0, 0.0, 0.0, 0.0)",
        "return Alarm(NOTHING, 0.0, 0.0, 0.0, 1.0)",
    ): "of an alarm without a cause nothing but the cause is read",
}
