"""Every field of a scenario, walked by its schema: what is refused, and how the message names it."""

import math
import re
from functools import cache

import pytest
from scenario_files import REMOVED, built_in, changed, refused

from adaptive_ff import InputError, Scenario, load_scenario, parse_scenario

SCHEMA = Scenario.model_json_schema()

ALLOWED = {
    "positive": """
        duration inertia stribeck_velocity stribeck_shape gear_ratio stiffness attraction link_stiffness rolling_range
        hysteresis_reach displacements.0 shares.0 presliding solver_period period encoder_resolution ripple_period
        cutoff acceleration_walk torque_limit rate_limit gain limit frequencies.0 peak speed acceleration jerk hold
        bandwidth proportional memory ripple_periods.0 position_periods.0 warm_up_time position_period thermal_time
        friction_scale coulomb_scale viscous_scale inertia_scale lag_scale
        inertia.0 coulomb.0 viscous.0 assumed_stribeck_velocity.0 assumed_inertia.0""",
    "at least 0": """
        coulomb stiction viscous coulomb_backward stiction_backward viscous_backward gravity friction_lag damping
        link_damping gap hysteresis velocity_noise leap ripple_amplitude torque_resolution delay lag fade_in pause.0
        dwell integral time load_share thermal_resistance thinning friction_lag.0 velocity_noise.0
        seed held position_hats fixed.inertia""",
    "any": """
        offset gravity_phase amplitudes.0 positions.0 velocities.0 cosines.0 sines.0 distance position_range.0 load""",
    "from 0 to below 1": "leap_share held_share position_amplitude",
    "between 0 and 1": "link_share",
    "from 0 to 1": "friction_share",
    "from 0 to 5": "jitter",
    "above 1": "exponent",
    "above -1": "warm_up_excess",
    "at least 1": "repeats stiction.0",
}
"""What physics allows of each number, by the name of its field, its limits apart that memory and float set."""

LIMITS = {
    "positive": {"exclusiveMinimum": 0},
    "at least 0": {"minimum": 0},
    "any": {},
    "from 0 to below 1": {"minimum": 0, "exclusiveMaximum": 1},
    "between 0 and 1": {"exclusiveMinimum": 0, "exclusiveMaximum": 1},
    "from 0 to 1": {"minimum": 0, "maximum": 1},
    "from 0 to 5": {"minimum": 0, "maximum": 5},
    "above 1": {"exclusiveMinimum": 1},
    "above -1": {"exclusiveMinimum": -1},
    "at least 1": {"minimum": 1},
}
HELD_BY_MACHINES = {name: {"exclusiveMaximum": 2**63} for name in ("seed", "held", "repeats")}
HELD_BY_MACHINES["position_hats"] = {"maximum": 100}

REQUIRED = """
    joint feedback adaptation joint.inertia joint.coulomb joint.stiction joint.viscous joint.stribeck_velocity
    joint.stiffness joint.link_share joint.link_stiffness joint.gap joint.displacements joint.rolling_range
    joint.presliding reference.path reference.period reference.cosines reference.sines feedback.inertia
    adaptation.stribeck_velocity change.0.time"""


def below(bound):
    """The next number below a bound."""
    return bound - 1 if isinstance(bound, int) else math.nextafter(bound, -math.inf)


BOUNDS = {  # keyword of the schema: what lies beyond it, and how a message words it
    "exclusiveMinimum": (lambda b: (b, below(b)), lambda b: "positive" if b == 0 else f"greater than {b:g}"),
    "minimum": (lambda b: (below(b), b - 1), lambda b: f"greater than or equal to {b:g}"),
    "exclusiveMaximum": (lambda b: (b, b + 1), lambda b: f"less than {b:g}" if b < 1e9 else f"less than {b}"),
    "maximum": (lambda b: (b + 1,), lambda b: f"less than or equal to {b:g}"),
}


def places(schema, path=(), kinds=()):
    """All places of a scenario: path, schema there, and the kinds of the tables on the way, by path."""
    if "$ref" in schema:
        schema = SCHEMA["$defs"][schema["$ref"].rpartition("/")[2]]
    options = schema.get("anyOf", schema.get("oneOf", []))
    for option in options:
        tag = SCHEMA["$defs"][option["$ref"].rpartition("/")[2]]["properties"].get("kind") if "$ref" in option else None
        yield from places(option, path, ((*kinds, (path, tag["const"])) if tag else kinds))
    if not options:
        yield path, schema, kinds
    for name, field in schema.get("properties", {}).items():
        yield from places(field, (*path, name), kinds)
    if "items" in schema:
        yield from places(schema["items"], (*path, "0"), kinds)


@cache
def tables():
    """Schemas of the alternatives at each place, by table and then by path."""
    found = {}
    for path, schema, kinds in places(SCHEMA):
        is_inside = len(path) > 1 or schema.get("type") == "object"
        table = ".".join(path[:1] if is_inside else ()), dict(kinds).get(path[:1])
        found.setdefault(table, {}).setdefault((".".join(path), kinds), []).append(schema)
    return found


def put(content, path, value):
    """Content with a value at a path, in the first place of lists."""
    if not path:
        return value
    if path[0] == "0":
        return [put({}, path[1:], value)]
    content = content if isinstance(content, dict) else {}
    return {**content, path[0]: put(content.get(path[0], {}), path[1:], value)}


def content_with(path, kinds, value):
    """The built-in scenario with tables of some kinds, otherwise empty, and a value at a path."""
    content = built_in()
    for table, kind in kinds:
        content = put(content, table, {"kind": kind})
    return put(content, path.split(".") if isinstance(path, str) else path, value)


def refusal(content):
    """What the message says after the name of the scenario."""
    return refused("mine: ", parse_scenario, content, "mine")


def finding(content, path):
    """What the message says from a path on."""
    message = refusal(content)
    assert f"{path} = " in message
    return message[message.index(f"{path} = ") :]


def wrong_values(schema):
    """Values that a schema excludes, each with what a message says must be there."""
    kind = schema.get("type")
    if kind in ("number", "integer", "boolean", "array"):
        yield None, ""
    if kind == "number":
        for value in ("1", True, [1.0], {"a": 1.0}):
            yield value, "a finite number"
        for value in (math.nan, math.inf, -math.inf, 10**400):
            yield value, ""  # a limit may be named first
    if kind == "integer":
        for value in ("1", 1.0, True, [1]):
            yield value, "a valid integer"
        yield 10**400, ""
    if kind in ("number", "integer"):
        for keyword, (beyond, worded) in BOUNDS.items():
            for value in beyond(schema[keyword]) if keyword in schema else ():
                yield value if kind == "integer" else float(value), worded(schema[keyword])
    if "const" in schema or "enum" in schema:
        allowed = schema.get("enum", [schema.get("const")])
        for value in ("noise", "", allowed[0].upper(), 3, True):
            yield value, repr(allowed[0])
    elif kind == "string":
        for value in (1, 1.0, True, ["a"], {"a": "b"}):
            yield value, "a valid string"
        if schema.get("minLength"):
            yield "", "at least 1 character"
    if kind == "boolean":
        for value in ("no", 0, 1.0, [True]):
            yield value, "a valid boolean"
    if kind == "array":
        for value in ("a", 1.0, True, {"a": 1}):
            yield value, "a list of tables; in a file write [[change]]" if "$ref" in schema["items"] else "a valid list"
        if schema.get("minItems"):
            yield [], f"at least {schema['minItems']} item"
    if kind == "object":
        for value in ("a", 1.0, True, [1.0], [[]]):
            yield value, "a table"


def test_schema_of_each_number_has_the_limits_of_physics():
    """A new field is in the list above before anything else is green."""
    by_name = {name: LIMITS[rule] for rule, names in ALLOWED.items() for name in names.split()}
    seen = set()
    for path, schema, _ in places(SCHEMA):
        if schema.get("type") not in ("number", "integer"):
            continue
        *parents, last = path
        name = f"{parents[-1]}.0" if last == "0" else last
        name = ".".join(path) if ".".join(path) in by_name else name
        limits = {keyword: schema[keyword] for keyword in BOUNDS if keyword in schema}
        assert limits == {**by_name[name], **HELD_BY_MACHINES.get(name, {})}, ".".join(path)
        seen.add(name)
    assert seen == set(by_name)


def test_schema_of_each_list_has_the_length_of_what_it_holds():
    pairs = ["position_range", "pause", "inertia", "coulomb", "viscous", "stiction", "friction_lag", "velocity_noise"]
    pairs += ["assumed_stribeck_velocity", "assumed_inertia"]
    lengths = {**dict.fromkeys(pairs, (2, 2)), **dict.fromkeys(("displacements", "shares"), (4, 4))}
    lengths |= {"ripple_periods": (0, 8), "position_periods": (0, 7)}
    limited = {path[-1]: schema for path, schema, _ in places(SCHEMA) if "maxItems" in schema}
    assert {name: (one.get("minItems", 0), one["maxItems"]) for name, one in limited.items()} == lengths


@pytest.mark.parametrize("table", tables(), ids=lambda table: ":".join(map(str, table)))
def test_wrong_value_of_each_field_is_refused_with_its_path_and_what_is_allowed(table):
    for (path, kinds), schemas in tables()[table].items():
        if not path:
            continue
        types = {schema.get("type") for schema in schemas}
        for schema in schemas:
            for value, allowed in wrong_values(schema):
                if value is None and "null" in types:
                    continue
                if len(types) > 1:  # a word or a number: what is neither is refused by one of two rules
                    allowed = ""
                    if type(value) in (int, float) and schema["type"] == "string":
                        continue
                said = finding(content_with(path, kinds if not path.endswith("kind") else (), value), path)
                shown = repr(str(value) if path.endswith("kind") else value)
                assert said.startswith(f"{path} = {shown[:50]}"), said
                assert "is not allowed: it must " in said, said
                assert allowed in said, said


def whole(content):
    """Content with integers in the place of whole numbers."""
    if isinstance(content, dict):
        return {key: whole(value) for key, value in content.items()}
    if isinstance(content, list):
        return [whole(value) for value in content]
    return int(content) if isinstance(content, float) and content.is_integer() else content


def test_whole_number_is_a_number():
    content = {
        **built_in(),
        "duration": 60.0,
        "change": [{"time": 30.0, "load": 5.0}],
        "fixed": {"coulomb": 60.0},
        "sweep": {"inertia": [1.0, 10.0], "stiction": [1.0, 2.0]},
        "position": {"gain": 5.0, "limit": 1.0},
        "adaptation": {"stribeck_velocity": 1.0, "memory": 20.0, "position_hats": 3, "position_range": [-1.0, 2.0]},
    }
    assert parse_scenario(whole(content), "mine").model_dump_json() == parse_scenario(content, "mine").model_dump_json()


def test_field_that_is_missing_is_named():
    required = set()
    for path, schema, kinds in places(SCHEMA):
        for name in {*schema.get("required", [])} - {"kind"}:
            place = ".".join((*path, name))
            content = changed(content_with(place, kinds, 1.0), place, REMOVED)
            listed, _, rest = refusal(content).partition(" missing; ")
            assert place in listed.replace(",", " ").split()
            assert rest.startswith(("it must be given", "they must be given"))
            required.add(place)
    assert required == set(REQUIRED.split())


@pytest.mark.parametrize("key", ["inertai", "csv", "", "a.b", "a b\n"])
def test_unknown_key_is_refused_and_the_known_are_listed(key):
    for path, schema, kinds in places(SCHEMA):
        if schema.get("type") != "object":
            continue
        known, place = list(schema["properties"]), ".".join((*path, key if key.isalpha() else repr(key)))
        near = next((name for name in ("inertia", "inertia_scale") if name in known and key == "inertai"), None)
        hint = f"did you mean {near}? " if near else ""
        message = finding(content_with((*path, key), kinds, 1.0), place)
        assert message.startswith(f"{place} = 1.0 is not known; {hint}allowed there: {', '.join(known)}")


@pytest.mark.parametrize("names", [["pi", "pi"], ["pi", "adaptive", "pi"]])
def test_controller_that_is_named_twice_is_refused(names):
    said = rf"controllers = {re.escape(repr(names))} is not allowed: it must have every name"
    with pytest.raises(InputError, match=said):
        parse_scenario({**built_in(), "controllers": names}, "mine")


def test_reference_without_a_kind_is_recorded_where_it_has_a_path_and_else_a_multisine():
    content = changed(built_in(), "reference.kind", REMOVED)
    assert parse_scenario(content, "test").reference.kind == "multisine"
    with pytest.raises(InputError, match=r"gone\.csv: cannot be read"):
        parse_scenario({**content, "reference": {"path": "gone.csv"}}, "test")
    message = refusal({**content, "reference": {"path": "gone.csv", "peak": 1.0}})
    assert message == "reference.peak = 1.0 is not known; allowed there: kind, path, time, velocity, position"


def test_all_that_is_missing_or_wrong_is_named_at_once():
    content = changed(changed(built_in(), "joint.inertia", -1.0), "fixed.viscous", "x")
    for path in ("joint.coulomb", "feedback.inertia", "adaptation"):
        content = changed(content, path, REMOVED)
    assert refusal(content) == (
        "joint.coulomb, feedback.inertia and adaptation are missing; they must be given; "
        "joint.inertia = -1.0 is not allowed: it must be positive; "
        "fixed.viscous = 'x' is not allowed: it must be a finite number"
    )


def test_many_wrong_fields_are_counted_beyond_what_a_person_reads():
    message = refusal(changed(built_in(), "reference.frequencies", [-1.0] * 20))
    assert message.count("is not allowed: it must be positive") == 12
    assert message.endswith("; and 8 more")


def test_value_too_large_to_be_shown_is_refused_all_the_same(tmp_path):
    path = tmp_path / "scenario.toml"
    path.write_text(f"duration = 0x{'f' * 5000}", encoding="utf-8")
    with pytest.raises(InputError, match=r"duration = \(a huge int\) is not allowed: it must be a finite number"):
        load_scenario(path)
    path.write_text(f"duration.{'a.' * 5000}a = 1", encoding="utf-8")
    shown = r"(\(a huge dict\)|\{'a': [^;]{51}\.\.\.)"  # newer versions of Python show so many levels
    with pytest.raises(InputError, match=rf"duration = {shown} is not allowed: it must be a finite number"):
        load_scenario(path)
