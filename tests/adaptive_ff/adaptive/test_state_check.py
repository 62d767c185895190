"""A restored state of a controller with every column; what is refused of a state, the figures hold."""

from exports import adaptive


def test_a_new_state_is_restored_by_a_controller_with_every_column():
    columns = {"regressors": 2, "ripple_periods": [0.3], "position_periods": [1.0], "position_hats": 5}
    new, restored = (adaptive(**columns, load_friction=True) for _ in range(2))
    text = new.state_to_json()
    restored.state_from_json(text)
    assert restored.state_to_json() == text
