"""Scenarios: what is simulated, and what each controller assumes of it."""

import os
import tomllib
from collections.abc import Mapping
from pathlib import Path
from types import NoneType
from typing import Any, Self

from pydantic import ValidationError, model_validator

from adaptive_ff.errors import InputError, check_kind, read_text
from adaptive_ff.scenario.axis_units import axis_unit
from adaptive_ff.scenario.content import Content
from adaptive_ff.scenario.library import scenario_file
from adaptive_ff.scenario.loop import loop_cautions
from adaptive_ff.scenario.plausibility import motion_cautions
from adaptive_ff.scenario.relations import RELATIONS
from adaptive_ff.scenario.tables import FixedModel
from adaptive_ff.scenario.validation import explain

BUILT_IN = Path(__file__).with_name("reference_joint.toml")  # the built-in scenario


class Scenario(Content):
    """A simulated joint, its sensor and drive, the reference, and what each controller assumes of them.

    Its fields are those of a scenario file. Use :func:`load_scenario` to read one, ``modified`` to derive another.
    """

    @model_validator(mode="after")
    def _check_relations(self) -> Self:
        for check in RELATIONS:
            check(self)
        return self

    def cautions(self) -> list[str]:
        """Return what is allowed but probably not meant, a sentence each."""
        found = []
        limit, torque = self.actuator.torque_limit, axis_unit(self.joint.axis, "N m")
        if limit is not None and limit < self.joint.stiction:
            found.append(
                f"actuator.torque_limit = {limit:g} {torque} is below joint.stiction = {self.joint.stiction:g} "
                f"{torque}: tracking is impossible, the joint cannot break away from rest"
            )
        if "controllers" in self.model_fields_set and "fixed" in self.controllers and self.fixed == FixedModel():
            found.append("controller 'fixed' has nothing in [fixed]: it feeds nothing forward and equals 'pi'")
        found += motion_cautions(self.joint, limit, self.reference_velocity(), self.joint.solver_period)
        return found if self.feedback.is_auto else [*found, *loop_cautions(self)]

    def modified(self, **tables: Any) -> "Scenario":
        """Return a scenario with other values.

        Parameters
        ----------
        **tables
            New values by field; a dict changes only the given fields of a table.

        Examples
        --------
        >>> from adaptive_ff import load_scenario
        >>> load_scenario().modified(seed=2, sampling={"period": 0.001}).sampling.period
        0.001
        """
        content, defaults = self.model_dump(exclude_unset=True), self.model_dump()
        for name, value in tables.items():
            old = content.get(name, defaults.get(name))
            kept = old if isinstance(old, dict) and isinstance(value, dict) else {}
            if kept and value.get("kind") not in (None, defaults[name].get("kind")):
                kept = {}
            content[name] = {**kept, **value} if isinstance(value, dict) else value
        derived = parse_scenario(content, "scenario")
        derived.__dict__["name"] = self.name if self.name.endswith(" changed") else f"{self.name}, changed"
        return derived

    def replaced(self, **tables: Any) -> "Scenario":
        """Return a scenario with whole tables, or other values, in the place of its own."""
        return Scenario.model_validate({**self.model_dump(exclude_unset=True), **tables})


def parse_scenario(content: dict[str, Any], name: str, folder: Path | None = None) -> Scenario:
    """Check the content of a scenario.

    Parameters
    ----------
    content : dict
        Tables and fields, as in a scenario file.
    name : str
        Where it comes from, for messages.
    folder : Path, optional
        Folder that the path of a recorded reference is relative to.

    Raises
    ------
    InputError
        A field is wrong; the message names it, its value and what is allowed.
    TypeError
        The content is no table, or the folder no path.
    """
    check_kind("content", content, Mapping, "tables and fields by name; load_scenario(path) reads a file")
    check_kind("folder", folder, (str, os.PathLike, NoneType), "a path")
    reference = content.get("reference")
    if folder is not None and isinstance(reference, dict) and isinstance(reference.get("path"), str):
        content = {**content, "reference": {**reference, "path": str(Path(folder) / reference["path"])}}
    try:
        scenario = Scenario.model_validate(content)
        scenario.__dict__["name"] = name  # in the place of the cached property: no field, so that it is no setting
        scenario.check_reference()
    except ValidationError as error:
        raise InputError(f"{name}: {explain(error, Scenario)}") from error
    except InputError as error:
        raise InputError(f"{name}: {error}") from error
    except ArithmeticError as error:
        raise InputError(f"{name}: a value is too large or too small to reckon with: {error}") from error
    return scenario


def load_scenario(path: str | Path | None = None, reference: str | Path | None = None) -> Scenario:
    """Read a scenario file.

    Parameters
    ----------
    path : str or Path, optional
        A TOML file, or the name of a scenario of the package; the built-in scenario by default.
    reference : str or Path, optional
        A recorded reference (CSV) instead of the one in the file.

    Returns
    -------
    Scenario
        The scenario, checked.

    Raises
    ------
    InputError
        The file cannot be read, or a field is wrong.
    TypeError
        A path is none.
    """
    check_kind("path", path, (str, os.PathLike, NoneType), "a path; parse_scenario(tables, name) takes tables")
    check_kind("reference", reference, (str, os.PathLike, NoneType), "a path")
    file = BUILT_IN if path is None else scenario_file(Path(path))
    text = read_text(file, "is not valid TOML", "utf-8-sig")
    try:
        content = tomllib.loads(text)
    except (tomllib.TOMLDecodeError, RecursionError, ValueError) as error:
        raise InputError(f"{file}: is not valid TOML: {' '.join(str(error).split())}") from error
    name = "built-in scenario" if path is None else str(path)
    if reference is None:
        return parse_scenario(content, name, file.parent)
    return parse_scenario({**content, "reference": {"kind": "csv", "path": str(reference)}}, name)


def check_scenario(scenario: Any) -> None:
    """Raise a TypeError for what is no scenario, such as the path of one."""
    rule = "a Scenario: load_scenario(path) reads a file, parse_scenario(tables, name) takes tables"
    check_kind("scenario", scenario, Scenario, rule)
