"""Comments of the scenario of an identified joint: each parameter has its own interval."""

from adaptive_ff import load_scenario, simulate
from adaptive_ff.identify.identification import identify_log
from adaptive_ff.identify.words.scenario_text import scenario_text
from adaptive_ff.logs.log import Log


def test_stribeck_velocity_has_its_own_interval_and_not_that_of_stiction():
    scenario = load_scenario().modified(sampling={"period": 0.001}, seed=101, controllers=["oracle"])
    columns = simulate(scenario, "oracle").columns()
    log = Log("run", columns["time"], columns["torque"], velocity=columns["measured"])
    found = identify_log(log, torque_delay=0.0005)
    assert found.parameters["stiction"].identifiable
    lines = scenario_text(found, "reference.csv").splitlines()
    for name in ("stiction", "stribeck_velocity"):
        estimate = found.parameters[name].estimate
        (line, *_) = [line for line in lines if line.startswith(f"{name} =")]
        assert f"interval {estimate.lower:.4g} to {estimate.upper:.4g}" in line
