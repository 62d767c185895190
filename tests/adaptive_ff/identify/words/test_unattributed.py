"""Logs that show friction without telling which, and verdicts that claim no more than the table."""

from dataclasses import replace

import numpy as np
import pytest
from command_line import content_of, run_command_line

from adaptive_ff import InputError
from adaptive_ff.files import write_csv
from adaptive_ff.identify.identification import identify_log
from adaptive_ff.identify.words.scenario_text import scenario_text
from adaptive_ff.identify.words.unattributed import unattributed
from adaptive_ff.logs.log import Log
from adaptive_ff.report.parameter_tables import parameters_table

TIME = 0.005 * np.arange(12000)
SHAKEN = np.sin(2.0 * np.pi * 2.0 * TIME) + np.sin(2.0 * np.pi * 3.3 * TIME)
BOTH_WAYS = 0.3 * np.sin(2.0 * np.pi * 0.5 * TIME) + 0.2 * np.sin(2.0 * np.pi * 0.91 * TIME)


def make_log(velocity, coulomb=6.0, viscous=3.0, noise=0.5):
    torque = 2.0 * np.gradient(velocity, TIME) + coulomb * np.sign(velocity) + viscous * velocity
    torque += noise * np.random.default_rng(1).standard_normal(TIME.size)
    return Log("log", TIME, torque, velocity=velocity)


def test_log_at_nearly_one_speed_gets_a_warning_and_no_scenario(tmp_path):
    log = make_log(0.5 + 0.001 * SHAKEN)
    found = identify_log(log)
    assert found.parameters["inertia"].identifiable
    assert not found.parameters["coulomb"].identifiable
    said = "the log shows friction of 7.5 N m, but does not separate Coulomb friction from the rest of it"
    assert [caution for caution in found.cautions if caution.startswith(said)]
    with pytest.raises(InputError, match=rf"^log: {said}: record motion both ways"):
        scenario_text(found, "reference.csv")
    write_csv(tmp_path / "log.csv", {"time": log.time, "velocity": log.velocity, "torque": log.torque})
    outcome = run_command_line("identify", tmp_path / "log.csv", "--out", tmp_path / "out")
    assert outcome.status == 0
    assert any(said in warning for warning in outcome.warnings)
    assert "No scenario is written: " in outcome.out
    assert not {"scenario.toml", "reference.csv"} & set(content_of(tmp_path / "out"))


@pytest.mark.parametrize("viscous", [3.0, 0.0])
def test_joint_without_coulomb_friction_has_a_scenario_without_it(viscous):
    found = identify_log(make_log(BOTH_WAYS, coulomb=0.0, viscous=viscous, noise=0.3))
    assert not found.parameters["coulomb"].identifiable
    assert not [caution for caution in found.cautions if "does not separate" in caution]
    assert "\ncoulomb = 0.0 " in scenario_text(found, "reference.csv")


@pytest.mark.parametrize("velocity", [0.5 + 0.001 * SHAKEN, 0.5 + 0.002 * SHAKEN, BOTH_WAYS])
def test_verdict_lists_as_identifiable_what_the_table_has_no_remark_on(velocity):
    found = identify_log(make_log(velocity))
    table = parameters_table(found)
    names, *_, remarks = (list(column.cells) for column in table.columns)
    plain = {name.partition(",")[0] for name, remark in zip(names, remarks, strict=True) if not remark}
    (sentence,) = [line for line in found.verdict if line.startswith(("Identifiable", "No parameter"))]
    assert plain == {name for name, reported in found.parameters.items() if reported.is_known}
    assert ("Coulomb friction" in sentence) == ("coulomb" in plain)
    assert ("viscous friction" in sentence) == ("viscous" in plain)
    assert ("inertia" in sentence) == ("inertia" in plain)


def test_interval_of_what_is_confounded_is_said_to_be_so_in_the_scenario():
    found = identify_log(make_log(0.5 + 0.002 * SHAKEN))
    assert found.parameters["viscous"].confounded == ("coulomb",)
    lines = scenario_text(found, "reference.csv").splitlines()
    assert next(line for line in lines if line.startswith("viscous = ")).endswith(", confounded with coulomb")


def test_coulomb_friction_is_not_used_without_what_it_is_confounded_with():
    """A negative viscous coefficient is taken as zero; Coulomb friction without it is more than the log shows."""
    found = identify_log(make_log(0.5 + 0.002 * SHAKEN))
    coulomb, viscous = found.parameters["coulomb"], found.parameters["viscous"]
    twice = coulomb._replace(identifiable=True, estimate=coulomb.estimate._replace(value=15.0))
    negative = viscous._replace(identifiable=False, estimate=viscous.estimate._replace(value=-9.0))
    assert unattributed(found) == ""
    mixed = replace(found, parameters={**found.parameters, "coulomb": twice, "viscous": negative})
    assert "does not separate Coulomb friction" in unattributed(mixed)
    alone = replace(
        found, parameters={**found.parameters, "coulomb": twice, "viscous": viscous._replace(confounded=())}
    )
    assert unattributed(alone) == ""
