"""Controllers declared as arguments, state and step: one decorator makes the class.

A controller is a kernel ``step(parameters, state, inputs) -> (output, state)`` and a class around it that checks its
arguments, holds the state and is called once a sample. The class declares its arguments and what is derived of them;
``controller`` makes of that its ``__init__`` with all checks, the named tuple of parameters that the kernel is given,
the state at the start, the entries in the registries, and the documentation:

    class DeadBeatState(NamedTuple):
        feedback: PIState
        last: float = 0.0  # last torque, N m

    def step_dead_beat(parameters: "DeadBeat", state: DeadBeatState, inputs: Inputs) -> tuple[Output, DeadBeatState]:
        ...

    @controller(step_dead_beat, DeadBeatState)
    class DeadBeat(PILoop):
        \"\"\"``u = PI(e) + J/T (r - w)``.\"\"\"

        inertia: float = argument(positive, "Inertia, kg m^2.")

In the annotation of a kernel the class stands for its parameters, which have the same fields.
"""

import inspect
import math
import textwrap
from collections.abc import Callable
from functools import partial
from typing import Any, Literal, NamedTuple, TypeVar, dataclass_transform

from controllers.checks import check_numbers, check_positive
from controllers.interface import Controller
from controllers.registry import ESTIMATES, MONITORS, STEPS, without_estimates

Rule = Callable[[str, Any], Any]
"""Checks an argument, given its name and value, and returns what is kept of it."""

Declared = TypeVar("Declared", bound=type[Controller])

MISSING: Any = inspect.Parameter.empty
POSITIONAL, BY_NAME = inspect.Parameter.POSITIONAL_OR_KEYWORD, inspect.Parameter.KEYWORD_ONLY


class Field(NamedTuple):
    """An argument of a controller, or a value derived of its arguments; see :func:`argument` and :func:`derived`."""

    rule: Rule | None
    text: str
    default: Any
    kind: Any
    kept: bool


def argument(rule: Rule, text: str, *, default: Any = MISSING, kw_only: bool = True, kept: bool = True) -> Any:
    """Declare an argument.

    Parameters
    ----------
    rule : callable
        Returns the value to keep for a name and a value, or raises ``ValueError`` or ``TypeError``; see the ones below.
    text : str
        What it is, with its unit.
    default : object, optional
        Without one it is required.
    kw_only : bool, optional
        Whether it is given by name only.
    kept : bool, optional
        Whether the kernel is given it.
    """
    return Field(rule, text, default, BY_NAME if kw_only else POSITIONAL, kept)


def derived(text: str, *, init: Literal[False] = False) -> Any:
    """Declare a value that the method ``derive`` of the class computes from the arguments, for the kernel."""
    return Field(None, text, MISSING, None, True)


class Begin(NamedTuple):
    """A value of the state at the start that depends on the parameters; see :func:`begin`."""

    make: Callable[[Any], Any]

    def __repr__(self) -> str:
        return "begin(...)"  # without an address, as the keys of compiled code hold it


def begin(make: Callable[[Any], Any]) -> Any:
    """Declare a field of a state whose value at the start is made from the parameters."""
    return Begin(make)


_INITIAL: dict[type, Callable[[Any], Any]] = {}


def initial_state(parameters: Any) -> Any:
    """Return the state of a controller at rest, for the parameters of any class that is registered."""
    return _INITIAL[type(parameters)](parameters)


def _state_at_rest(kind: Any, parameters: Any) -> Any:
    """Return a state: fields with their defaults; one without is the state of the parameters of its name."""
    values = {}
    for name in kind._fields:
        value = kind._field_defaults[name] if name in kind._field_defaults else initial_state(getattr(parameters, name))
        values[name] = value.make(parameters) if isinstance(value, Begin) else value
    return kind(**values)


def register(
    kind: type,
    step: Callable[..., Any],
    initial: Callable[[Any], Any],
    *,
    estimates: Callable[..., Any] = without_estimates,
) -> None:
    """Let loops, compiled ones included, find the kernels of a class of parameters.

    They are ``step(parameters, state, inputs) -> (output, state)`` and ``estimates(parameters, state, row)``;
    ``initial`` makes the state at rest from the parameters.
    """
    STEPS[kind], ESTIMATES[kind], MONITORS[kind], _INITIAL[kind] = step, estimates, without_estimates, initial


@dataclass_transform(kw_only_default=True, field_specifiers=(argument, derived))
def controller(
    step: Callable[..., Any] | None = None,
    state: type | None = None,
    *,
    estimates: Callable[..., Any] = without_estimates,
) -> Callable[[Declared], Declared]:
    """Make a controller of a class that declares its arguments.

    Parameters
    ----------
    step : callable, optional
        Kernel ``step(parameters, state, inputs) -> (output, state)``; without one the class is a base of others.
    state : type, optional
        Named tuple of its state, with the values at the start as defaults, see :func:`begin`; the state of a loop
        inside needs none.
    estimates : callable, optional
        Kernel ``write(parameters, state, row)`` of the estimates that ``estimate_names`` of the class names.
    """

    def declare(cls: Any) -> Any:
        own = {name: value for name, value in vars(cls).items() if isinstance(value, Field)}
        inherited: dict[str, Field] = {
            name: own.get(name, field) for name, field in getattr(cls, "_declared", {}).items()
        }
        cls._declared = {**inherited, **own}
        for name, field in own.items():
            setattr(cls, name, property(_reader(name, field)))
        if "period" in own:
            del cls.period  # every controller has it as an attribute
        if step is None:
            return cls
        added = {name: field for name, field in own.items() if name not in inherited}
        arguments = {name: field for name, field in {**added, **inherited}.items() if field.rule}
        positional = {name: field for name, field in cls._declared.items() if field.kind is POSITIONAL}
        arguments = positional | arguments
        hints = {name: hint for base in reversed(cls.__mro__) for name, hint in inspect.get_annotations(base).items()}
        cls.__init__ = _made_init(arguments, hints)
        cls.__doc__ = _documented(cls, arguments, hints)
        loops = [name for name, field in inherited.items() if not field.rule]
        kept = {name: None for name in (*loops, *added, *inherited) if cls._declared[name].kept}
        cls.Parameters = _parameters_class(cls, [(name, hints[name]) for name in kept])
        register(cls.Parameters, step, partial(_state_at_rest, state), estimates=estimates)
        return cls

    return declare


def _reader(name: str, field: Field) -> Callable[[Any], Any]:
    """Return what reads an argument, or a value that is derived of some, of a controller."""
    if field.rule is None:
        return lambda self: getattr(self.parameters, name)
    return lambda self: self._arguments[name]


def _made_init(arguments: dict[str, Field], hints: dict[str, Any]) -> Callable[..., None]:
    """Return the ``__init__`` of a class, whose signature names the arguments."""
    parameters = [
        inspect.Parameter(name, field.kind, default=field.default, annotation=hints[name])
        for name, field in arguments.items()
    ]
    signature = inspect.Signature([inspect.Parameter("self", POSITIONAL), *parameters], return_annotation=None)

    def __init__(self: Any, *args: Any, **given: Any) -> None:
        bound = signature.bind(self, *args, **given)
        bound.apply_defaults()
        self._arguments = {name: field.rule(name, bound.arguments[name]) for name, field in arguments.items()}  # type: ignore[misc]
        self.period = self._arguments["period"]
        values: dict[str, Any] = dict(self._arguments)
        for base in reversed(type(self).__mro__):
            if "derive" in vars(base):
                values |= base.derive(self)  # type: ignore[attr-defined]
        kept = self.Parameters(**{name: values[name] for name in self.Parameters._fields})
        Controller.__init__(self, kept, values["period"], initial_state)

    __init__.__signature__ = signature  # type: ignore[attr-defined]
    return __init__


def _parameters_class(cls: Any, fields: list[tuple[str, Any]]) -> Any:
    """Return the class of what the kernel is given, found by pickle as ``Class.Parameters``."""
    made: Any = NamedTuple(f"{cls.__name__}Parameters", fields)  # type: ignore[misc]
    made.__module__, made.__qualname__ = cls.__module__, f"{cls.__qualname__}.Parameters"
    lines = [f"What the kernel of :class:`{cls.__name__}` is given.", "", "Attributes", "----------"]
    for name, hint in fields:
        lines += [f"{name} : {inspect.formatannotation(hint)}", f"    {cls._declared[name].text}"]
    made.__doc__ = "\n".join(lines)
    return made


def _documented(cls: Any, arguments: dict[str, Field], hints: dict[str, Any]) -> str:
    """Return the docstring of a class with the sections of its arguments and errors before its examples."""
    text, heading, examples = (inspect.getdoc(cls) or "").partition("\n\nExamples\n")
    lines = ["Parameters", "----------"]
    for name, field in arguments.items():
        optional = "" if field.default is MISSING else ", optional"
        lines += [f"{name} : {inspect.formatannotation(hints[name]).replace('collections.abc.', '')}{optional}"]
        lines += textwrap.wrap(field.text, 112, initial_indent="    ", subsequent_indent="    ")
    lines += ["", "Raises", "------", "ValueError", "    A value is out of range."]
    lines += ["TypeError", "    A value is of another kind."]
    return "\n".join([text, "", *lines]) + heading + examples


def positive(name: str, value: Any) -> float:
    """Check that a number is positive and finite."""
    check_positive(**{name: value})
    return float(value)


def as_given(name: str, value: Any) -> Any:
    """Leave the check to ``derive`` of the class."""
    return value


def within(allowed: str, holds: Callable[[float], bool]) -> Rule:
    """Return the rule that a condition holds for a number; ``allowed`` ends the sentence "it must be"."""

    def rule(name: str, value: Any) -> float:
        check_numbers(**{name: value})
        if not holds(value):
            raise ValueError(f"{name} = {value} is not allowed: it must be {allowed}")
        return float(value)

    rule.__doc__ = f"Check that a number is {allowed}."
    return rule


fraction = within("from 0 to 1", lambda value: 0.0 <= value <= 1.0)
portion = within("above 0 and at most 1", lambda value: 0.0 < value <= 1.0)
not_negative = within("finite and not negative", lambda value: 0.0 <= value < math.inf)
