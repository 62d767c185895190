"""Series as MCAP, read back by the library of the format and as a log; the layout names series that are there."""

import json
from xml.etree import ElementTree

import numpy as np
import pytest
from command_line import run_command_line
from mcap.reader import make_reader

from adaptive_ff import InputError, compare, load_scenario, read_log
from adaptive_ff.report import viewers
from adaptive_ff.reported import Reported

SCENARIO = load_scenario().modified(duration=12.0, controllers=["pi", "adaptive"])


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    from adaptive_ff.scenario.file import to_toml

    place = tmp_path_factory.mktemp("viewers")
    (place / "short.toml").write_text(to_toml(SCENARIO))
    log = ["results/pi.csv", "--velocity", "measured", "--torque", "torque"]
    with pytest.MonkeyPatch.context() as monkey:
        monkey.setattr(Reported, "plot", lambda result, folder: {})
        monkey.chdir(place)
        for command in (["compare", "short.toml"], ["identify", *log], ["replay", *log]):
            done = run_command_line(*command, "--mcap", f"{command[0]}.mcap")
            assert done.status == 0, done.err
    return place


def contents(file):
    """Topics with their schema, times and messages."""
    with file.open("rb") as stream:
        reader = make_reader(stream)
        found = {}
        for schema, channel, message in reader.iter_messages():
            assert (schema.encoding, channel.message_encoding) == ("jsonschema", "json")
            assert schema.name.startswith("adaptive_ff.")
            times, messages = found.setdefault(channel.topic, (json.loads(schema.data), [], []))[1:]
            times.append(message.log_time)
            messages.append(json.loads(message.data))
        return found


@pytest.mark.parametrize(
    ("command", "topics"),
    [
        ("compare", {"/pi", "/adaptive", "/adaptive/bounds"}),
        ("identify", {"/log", "/parameters"}),
        ("replay", {"/log", "/fixed", "/adaptive"}),
    ],
)
def test_messages_are_those_of_their_schema_and_curves_of_the_layout_are_in_them(folder, command, topics):
    found = contents(folder / f"{command}.mcap")
    assert topics <= set(found)
    names = set()
    for topic, (schema, times, messages) in found.items():
        assert times == sorted(times)
        for part, content in schema["properties"].items():
            names |= {f"{topic}/{part}/{one}" for one in content["properties"]}
            assert {type(value) for message in messages for value in message[part].values()} == {float}
            assert all(set(message[part]) <= set(content["properties"]) for message in messages)
    curves = {curve.get("name") for curve in ElementTree.parse(folder / f"{command}.xml").iter("curve")}
    assert curves
    assert curves <= names


def test_values_are_those_of_the_run_and_read_as_a_log(folder):
    run, found = compare(SCENARIO).runs["adaptive"], contents(folder / "compare.mcap")
    schema, times, messages = found["/adaptive"]
    assert schema["properties"]["torque"]["properties"]["feedforward"] == {"type": "number", "description": "N m"}
    assert np.allclose(np.array(times) * 1e-9, run.time, atol=1e-9)
    names = ("feedforward", "feedback", "applied")
    parts = np.array([[message["torque"][name] for name in names] for message in messages])
    assert np.array_equal(parts[:, 2], run.torque)
    assert np.allclose(parts[:, 0] + parts[:, 1], parts[:, 2])
    bounds = found["/adaptive/bounds"][2]
    assert bounds[-1]["coulomb"]["lower"] < run.final_estimates["coulomb"] < bounds[-1]["coulomb"]["upper"]
    named = {"velocity": "pi.motion.measured", "torque": "pi.torque.applied", "time": "pi.log_time"}
    assert len(read_log(folder / "compare.mcap", **named).torque) == 1200


def test_missing_library_is_named(tmp_path, monkeypatch):
    def missing(name):
        raise ImportError(name)

    monkeypatch.setattr("importlib.import_module", missing)
    with pytest.raises(InputError, match=r"^a\.mcap: .* pip install mcap"):
        viewers.write_mcap(tmp_path / "a.mcap", None)
