"""FMUs of controllers: importing tools find no problem, and a run in one gives the torques of Python."""

import platform
import re
import zipfile

import numpy as np
import pytest
from exports import SIZES, WARNINGS, adaptive, compiled, made, needs_gcc

from adaptive_ff import export_controller
from controllers import Inputs

fmpy = pytest.importorskip("fmpy", reason="fmpy (the extra fmu) is not installed")
from fmpy.validation import validate_fmu  # noqa: E402

pytestmark = [needs_gcc, pytest.mark.usefixtures("compiled_quickly")]
runs_here = pytest.mark.skipif(
    (platform.system(), platform.machine()) != ("Linux", "x86_64"), reason="FMI 2.0 has no name for this machine"
)


def written(folder, controller, version="2.0", **options):
    export_controller(controller, folder, prefix="drive", with_fmu=version, **options)
    return folder / "drive.fmu"


@pytest.fixture(scope="module", params=["2.0", "3.0"])
def learning(tmp_path_factory, request, compiled_quickly):
    return written(tmp_path_factory.mktemp("fmu"), adaptive(), request.param)


def test_that_of_pi_in_single_precision_is_valid(tmp_path):
    assert validate_fmu(str(written(tmp_path, made("pi"), single=True))) == []


def test_its_description_has_units_start_values_and_all_inputs(learning):
    assert validate_fmu(str(learning)) == []
    found = {variable.name: variable for variable in fmpy.read_model_description(str(learning)).modelVariables}
    assert {name for name in Inputs._fields if name != "dt"} <= set(found)
    assert found["reference"].unit == "rad/s"
    assert found["torque"].unit == "N m"
    assert found["inertia"].unit == "kg m^2"
    assert found["estimates.viscous"].unit == "N m s/rad"
    assert found["next_reference_known"].start == "false"
    assert found["realised_torque"].description.startswith("Used only while realised_torque_known is true.")
    assert found["enabled"].start == "true"
    assert found["velocity"].start == "0"


def simulated(file, expected, **series):
    """What an FMU gives every 10 ms of inputs by name; its torques are checked against those that are expected."""
    columns = {"time": 0.01 * np.arange(len(series["reference"])), **series}
    kinds = [(name, np.bool_ if name.endswith("known") else np.float64) for name in columns]
    signals = np.array(list(zip(*columns.values(), strict=True)), dtype=kinds)
    steps = {"stop_time": float(columns["time"][-1]), "step_size": 0.01, "output_interval": 0.01}
    result = fmpy.simulate_fmu(str(file), input=signals, **steps)
    torque = result["torque"][1:]  # what a communication step gives stands at its end
    assert torque.size >= len(expected) - 2
    # the tool's communication steps are differences of rounded times, not 0.01 s exactly
    assert np.allclose(torque, expected[: torque.size], rtol=1e-6, atol=1e-6 * np.ptp(torque))
    return result


@runs_here
def test_it_runs_as_in_python(learning):
    controller, reference = adaptive().run_uncompiled(), 0.2 * np.sin(0.03 * np.arange(300))
    velocity, following = np.roll(reference, 1) * 0.99, np.roll(reference, -1)
    known = {"next_reference": following, "next_reference_known": np.ones(300, dtype=bool)}
    rows = zip(reference, velocity, following, strict=True)
    expected = [controller.step(now, measured, next_reference=ahead) for now, measured, ahead in rows]
    result = simulated(learning, expected, reference=reference, velocity=velocity, **known)
    assert np.ptp(result["torque"][1:]) > 50.0
    assert result["estimates.coulomb"][-1] > 0.0


@runs_here
def test_further_known_regressors_are_inputs_of_it(tmp_path):
    def made_for_two():
        return adaptive(SIZES["offset"], regressors=2)

    file = written(tmp_path, made_for_two())
    assert validate_fmu(str(file)) == []
    controller, time = made_for_two().run_uncompiled(), 0.01 * np.arange(200)
    reference = 0.2 * np.sin(3.0 * time)
    columns = {"reference": reference, "velocity": np.roll(reference, 1) * 0.95}
    columns |= {"regressors[0]": np.sin(time), "regressors[1]": np.cos(2.0 * time)}
    rows = list(zip(*columns.values(), strict=True))
    expected = [controller.step(*row[:2], regressors=row[2:]) for row in rows]
    simulated(file, expected, **columns)
    without = made_for_two().run_uncompiled()
    blind = [without.step(*row[:2]) for row in rows]
    assert np.max(np.abs(np.subtract(blind, expected))) > 0.01 * np.ptp(expected)


def test_its_source_compiles_without_a_warning(learning, tmp_path):
    with zipfile.ZipFile(learning) as archive:
        archive.extractall(tmp_path)
    sources = [str(path.relative_to(tmp_path)) for path in (tmp_path / "sources").glob("*.c")]
    assert len(sources) == 2
    compiled(tmp_path, sources, "-O0", "-shared", "-fPIC", *WARNINGS, out="drive.so")
    tokens = re.findall(r"\{[0-9a-f-]{36}\}", (tmp_path / "sources" / "drive_fmu.c").read_text())
    described = fmpy.read_model_description(str(learning))
    assert tokens == [described.guid or described.instantiationToken]


def test_without_a_compiler_it_holds_the_source_alone(tmp_path, monkeypatch):
    monkeypatch.setenv("CC", "no-such-compiler")
    with zipfile.ZipFile(written(tmp_path, made("pi"))) as archive:
        names = archive.namelist()
    assert "sources/drive.c" in names
    assert not any(name.startswith("binaries") for name in names)
