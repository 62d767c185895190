"""A user's own controller: any object with a method ``step``, made anew for each scenario, in the same loop."""

import copy
import hashlib
import importlib.util
import math
import pickle
import sys
import zlib
from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache
from inspect import Parameter, signature
from pathlib import Path
from typing import Any, NamedTuple, Protocol

from numpy.typing import NDArray

from adaptive_ff.errors import InputError, check_kind
from adaptive_ff.scenario.scenario import Scenario
from controllers import ESTIMATES, STEPS, Inputs, Output

MODULE = "own_controller_"  # begins the names of the modules that own controllers are loaded as
FOLDERS: set[Path] = set()  # folders that own controllers were loaded from
NO_NAME = '/\\:*?"<>|'  # characters that the name of a file cannot have on one system or another

OFFERED = ("scenario", "proportional", "integral", "period", "inertia")
"""Arguments that a factory may take, by name."""


class OwnController(Protocol):
    """What a user's own controller must have; no need to derive from it.

    An object is copied for each run; a class or a factory is given those of ``scenario``, ``proportional``,
    ``integral``, ``period`` and ``inertia`` whose names it has.

    ``step`` is called once a sampling period, in plain Python. It is given only those keyword arguments that it accepts
    (all of them where it takes ``**others``), so the least is ``def step(self, reference, velocity, **_)``. What it may
    have beside ``step``, is recorded and drawn:

    - ``feedforward``: the feedforward in the last torque, N m;
    - ``estimates``: a mapping from names to numbers; the names of :class:`TorqueModel`'s fields are drawn beside the
      truth. It must have its names before the first step.
    """

    def step(
        self,
        reference: float,
        velocity: float,
        *,
        next_reference: float,
        correction: float,
        position: float | None,
        realised_torque: float | None,
        feedforward: float,
        inertia: float | None,
        dt: float,
        acting_reference: float | None,
        next_acting_reference: float | None,
    ) -> float:
        """Return the torque to command, N m.

        Arguments are those of :meth:`controllers.Controller.step`. None is what is not known: a position that is not
        measured, the torque before the first period, an inertia that does not vary, the plan beyond its end. Where
        ``step`` does not accept ``correction``, that is part of the planned velocities.
        """
        ...


Own = OwnController | Callable[..., Any] | str
"""An own controller: an object (copied for each run), a class or a factory, or ``FILE.py:NAME`` of one of these."""

GIVEN = tuple(name for name in Inputs._fields if name not in ("reference", "velocity"))
PLANNED = ("reference", "next_reference", "acting_reference", "next_acting_reference")
OPTIONAL = frozenset({"position", "realised_torque", "inertia", "acting_reference", "next_acting_reference"})
"""Arguments that a step may take by name, planned velocities, and what is None where it is not known."""


class Foreign(NamedTuple):
    """A user's own controller, as parameters of the loop in plain Python."""

    controller: Any  # has a method ``step`` like :meth:`controllers.Controller.step`
    call: Callable[..., Any]  # its ``step``, given those of the inputs in their order that it accepts
    estimate_names: tuple[str, ...] = ()  # names of its estimates


def _foreign(controller: Any, accepted: Sequence[str]) -> Foreign:
    """Return a controller whose step accepts keyword arguments of these names.

    Its call is written out: a mapping of arguments made anew for each sample would take longer than a PI step. Where it
    does not accept the correction of an outer loop, all it can follow is plan and outer loop together.
    """
    added = "" if "correction" in accepted else " + correction"
    values = {name: name + added * (name in PLANNED) for name in Inputs._fields}
    values |= {name: f"{values[name]} if isfinite({name}) else None" for name in OPTIONAL}
    given = [values["reference"], "velocity", *(f"{name}={values[name]}" for name in accepted)]
    text = f"lambda {', '.join(Inputs._fields)}: controller.step({', '.join(given)})"
    call = eval(text, {"controller": controller, "isfinite": math.isfinite})
    return Foreign(controller, call, tuple(getattr(controller, "estimates", None) or ()))


def own_controller(controller: Any) -> Foreign:
    """Return a user's controller with what the loop needs to know of it; refuse one that cannot be called."""
    try:
        taken = signature(controller.step)
    except (TypeError, ValueError):  # written in another language
        return _foreign(controller, GIVEN)
    kinds = {name: parameter.kind for name, parameter in taken.parameters.items()}
    named = (Parameter.KEYWORD_ONLY, Parameter.POSITIONAL_OR_KEYWORD)
    every = Parameter.VAR_KEYWORD in kinds.values()
    accepted = [name for name in GIVEN if every or kinds.get(name) in named]
    try:
        taken.bind(None, None, **dict.fromkeys(accepted))
    except TypeError as error:
        raise InputError(
            f"{_name(controller)} has step{taken} ({error}); it is called with reference and velocity, and by name "
            f"with those that it has of {', '.join(GIVEN)}"
        ) from error
    return _foreign(controller, accepted)


def step_own(parameters: Foreign, inputs: list[float]) -> tuple[float, float]:
    """Do one sample of a user's controller, given Python's numbers; return torque and feedforward, N m."""
    try:
        torque = parameters.call(*inputs)
    except SystemExit as error:  # a program that ends itself must not end this one without a word
        raise InputError(f"{_name(parameters.controller)} ends the program: SystemExit: {error}") from error
    value = _number(torque)
    if not math.isfinite(value):
        name = _name(parameters.controller)
        raise InputError(f"{name} returned a torque of {torque!r}; it must be a finite number")
    fed = _number(getattr(parameters.controller, "feedforward", 0.0))  # anything else of that name is no torque
    return value, fed if math.isfinite(fed) else 0.0


def write_own_estimates(parameters: Foreign, row: NDArray[Any]) -> None:
    """Write the estimates of a user's controller into a row."""
    for place, name in enumerate(parameters.estimate_names):
        given = parameters.controller.estimates.get(name)
        row[place] = _number(given)
        if not math.isfinite(row[place]):
            whose = _name(parameters.controller)
            raise InputError(f"{whose} has estimates[{name!r}] = {given!r}; it must be a finite number")


def _name(controller: Any) -> str:
    return f"the own controller {type(controller).__name__}"


def _number(value: Any) -> float:
    """Return a value as a number; not a number where it is none."""
    try:
        return float(value)
    except (TypeError, ValueError):
        return math.nan


STEPS[Foreign] = lambda parameters, state, inputs: (Output(*step_own(parameters, list(map(float, inputs)))), state)
ESTIMATES[Foreign] = lambda parameters, state, row: write_own_estimates(parameters, row)


def make_own(name: str, own: Own, scenario: Scenario) -> Any:
    """Make an own controller, which messages call by its name, for a scenario.

    An object is copied, so that each run begins with its state of now. A class, a factory, or ``FILE.py:NAME`` of one
    is given those of ``scenario``, ``proportional`` and ``integral`` (the PI gains of the scenario), ``period`` and
    ``inertia`` (that its feedback assumes) whose names it has.
    """
    if isinstance(own, str):
        own = load_own(own)
    if not isinstance(own, type) and callable(getattr(own, "step", None)):
        own_controller(own)
        try:
            return copy.deepcopy(own)
        except Exception as error:
            raise InputError(f"own controller {name!r} cannot be copied: {error}; give a class or a factory") from error
    if not callable(own):
        raise InputError(f"own controller {name!r} = {own!r} is not allowed: it must have a step or make what has one")
    made = own(**_arguments(name, own, scenario))
    if not callable(getattr(made, "step", None)):
        raise InputError(f"own controller {name!r} made {made!r}, which has no method step")
    own_controller(made)
    return made


def _arguments(name: str, factory: Callable[..., Any], scenario: Scenario) -> dict[str, Any]:
    """Return the arguments that a factory is called with."""
    proportional, integral = scenario.feedback.gains
    values = (scenario, proportional, integral, scenario.sampling.period, scenario.feedback.inertia)
    offered = dict(zip(OFFERED, values, strict=True))
    try:
        parameters = list(signature(factory).parameters.values())
    except (TypeError, ValueError):  # a class written in another language
        return {}
    if any(parameter.kind is Parameter.VAR_KEYWORD for parameter in parameters):
        return offered
    needed = [one for one in parameters if one.default is Parameter.empty and one.kind is not Parameter.VAR_POSITIONAL]
    strangers = [one.name for one in needed if one.name not in offered]
    if strangers:
        raise InputError(
            f"own controller {name!r} needs {', '.join(strangers)}; a class or factory is given {', '.join(OFFERED)}"
        )
    return {one.name: offered[one.name] for one in parameters if one.name in offered}


def _forget_namesakes(folder: Path) -> None:
    """Forget modules of other own controllers' folders where this folder has one of the same name."""
    for name, module in list(sys.modules.items()):
        home = Path(getattr(module, "__file__", None) or "").parent
        if home in FOLDERS and home != folder and (folder / f"{name}.py").is_file():
            del sys.modules[name]


@lru_cache(maxsize=64)
def load_own(place: str) -> Any:
    """Load an own controller from ``FILE.py:NAME``; the error lists the names that there are."""
    file, colon, name = place.rpartition(":")
    path = Path(file)
    if not (colon and name.isidentifier() and path.suffix == ".py"):
        raise InputError(f"own controller {place!r} is not allowed: it must be FILE.py:NAME, such as mine.py:Mine")
    if not path.is_file():
        raise InputError(f"{path}: cannot be read: there is no such file")
    folder = path.resolve().parent
    stem = f"{MODULE}{path.stem}_{zlib.crc32(str(folder).encode()):08x}"
    spec = importlib.util.spec_from_file_location(stem, path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[stem] = module
    _forget_namesakes(folder)
    sys.path.insert(0, str(folder))  # so that it may import what lies beside it
    try:
        spec.loader.exec_module(module)
    except (Exception, SystemExit) as error:  # a program that ends itself must not end this one without a word
        raise InputError(f"{path}: cannot be loaded: {type(error).__name__}: {error}") from error
    finally:
        sys.path.remove(str(folder))
        if str(folder) not in sys.path:
            sys.path.append(str(folder))  # and may do so later
        FOLDERS.add(folder)
    if not hasattr(module, name):
        own = [key for key, value in vars(module).items() if getattr(value, "__module__", None) == stem]
        raise InputError(f"{path}: there is no {name}; there are {', '.join(own) or 'no classes or functions'}")
    return getattr(module, name)


def named_own(places: list[str]) -> dict[str, Own]:
    """Return own controllers by name, from ``[NAME=]FILE.py:OBJECT`` as a command line gives them."""
    found: dict[str, Own] = {}
    for given in places:
        name, _, place = given.partition("=") if "=" in given else (given.rpartition(":")[2], "", given)
        if name in found:
            raise InputError(f"--own {given}: there are two own controllers {name!r}; write NAME={place}")
        load_own(place)
        found[name] = place
    return found


def check_own_names(own: Mapping[str, Own], taken: Mapping[str, Any]) -> None:
    """Refuse an own controller whose name is one of the package, or cannot begin the name of a file."""
    check_kind("own", own, Mapping, "controllers by name, such as {'mine': Mine}")
    for name in own:
        check_kind("own: a name", name, str, "a text")
        if name in taken:
            raise InputError(f"own = {name!r} is not allowed: that is the name of a controller of this package")
        if not name.strip(" .") or not name.isprintable() or any(mark in name for mark in NO_NAME):
            raise InputError(
                f"own = {name!r} is not allowed: it names files, so it must be printable, without any of "
                f"{' '.join(NO_NAME)}, and not empty"
            )


def own_marks(own: Mapping[str, Own]) -> dict[str, str | None]:
    """Return what identifies own controllers from one call to the next: their code; None for a living object."""
    return {name: f"{one}{_digest(one)}" if isinstance(one, str) else None for name, one in own.items()}


def _digest(place: str) -> str:
    """Return the digest of the file of an own controller, and of what it loads from beside it."""
    load_own(place)
    file = Path(place.rpartition(":")[0]).resolve()
    loaded = (Path(getattr(module, "__file__", None) or "").resolve() for module in list(sys.modules.values()))
    files = sorted({file, *(one for one in loaded if one.parent == file.parent and one.suffix == ".py")})
    return hashlib.sha256(b"".join(one.read_bytes() for one in files)).hexdigest()


def workers_for(own: Mapping[str, Own]) -> int | None:
    """Return how many workers run a study: one where another process cannot be sent the own controllers, else None.

    What is defined in a function or a lambda cannot be sent.
    """
    try:
        pickle.dumps(dict(own))
    except Exception:
        return 1
    return None
