"""Functions in C by which a program uses an exported controller, but for those of its saved state."""

import math

from adaptive_ff.adaptive.arguments import LARGEST_REGRESSOR
from adaptive_ff.export.export import Export
from adaptive_ff.export.sample import optional_inputs, unchecked_inputs
from adaptive_ff.export.tables import arrays_of, has_own_start
from controllers.kernels.comments import joined
from controllers.kernels.names import c_name
from controllers.kernels.types import Record, passed_by_pointer


def entry_points(export: Export) -> str:
    """Return the definitions."""
    return joined(
        [
            _bind(export),
            _starting(export),
            _restart(export),
            _default_inputs(export),
            _step(export),
            _regressors(export),
            *_switches(export),
        ]
    )


def estimates(export: Export) -> str:
    """Return the functions that give the physical estimates; nothing for a controller that has none."""
    names, prefix, upper = export.controller.estimate_names, export.prefix, export.upper
    if export.write_estimates is None:
        return ""
    body = [f"{export.unit.c_type(export.state)} own = controller->state;"]
    arrays = f"({prefix}_StateArrays *)&controller->state_arrays"  # which are read only
    body += [f"bind(&own, {arrays});"] if arrays_of(export.state_leaves) else []
    body += [f"{export.write_estimates.name}({', '.join(_passed(export, 'own'))}, estimates);"]
    listed = [
        f"static const char *const names[{upper}_ESTIMATES] = {{",
        *(f'    "{name}",' for name in names),
        "};",
        f"return place >= 0 && place < {upper}_ESTIMATES ? names[place] : NULL;",
    ]
    arguments = f"const {prefix}_Controller *controller, {export.precision.real} estimates[{upper}_ESTIMATES]"
    return joined(
        [
            _function(f"const char *{prefix}_estimate_name(int place)", listed),
            _function(f"void {prefix}_estimates({arguments})", body),
        ]
    )


def _function(head: str, lines: list[str]) -> str:
    return f"{head}\n{{\n    " + "\n    ".join(lines) + "\n}\n"


def _passed(export: Export, state: str) -> list[str]:
    """Return parameters and state of a controller as arguments of a kernel."""
    given = {"PARAMETERS": export.parameters, state: export.state}
    return [f"{'&' if passed_by_pointer(kind) else ''}{name}" for name, kind in given.items()]


BIND = "bind(&controller->state, &controller->state_arrays);"


def _bind(export: Export) -> str:
    lines = [f"state->{leaf.member} = arrays->{leaf.storage};" for leaf in arrays_of(export.state_leaves)]
    if not lines:
        return ""
    comment = "/* Let the arrays of a state be those of its controller, which may be a copy of another. */\n"
    head = f"static void bind({export.unit.c_type(export.state)} *state, {export.prefix}_StateArrays *arrays)"
    return comment + _function(head, lines)


def _starting(export: Export) -> str:
    prefix = export.prefix
    return joined(
        [
            _function(f"void {prefix}_{name}({prefix}_Controller *controller)", _beginning(export, state))
            for name, state in (("init", "START" if has_own_start(export) else "NEW"), ("reset", "NEW"))
        ]
    )


def _beginning(export: Export, state: str) -> list[str]:
    lines = [f"controller->state = {state}_STATE;"]
    if arrays_of(export.state_leaves):
        lines += [f"controller->state_arrays = {state}_STATE_ARRAYS;", BIND]
    return lines


def _restart(export: Export) -> str:
    """Return the function that forgets the motion, as ``restart`` does in Python."""
    lines = []
    for leaf, value in export.restarted:
        if leaf.is_array and leaf.count:
            place = f"controller->state_arrays.{leaf.storage}"
            lines += [f"memset({place}, 0,", f"    sizeof {place});"]
        elif not leaf.is_array:
            lines.append(f"controller->state.{leaf.member} = {export.precision.literal(value, leaf.member)};")
    return _function(f"void {export.prefix}_restart({export.prefix}_Controller *controller)", lines)


def _default_inputs(export: Export) -> str:
    values = {name: export.precision.literal(0.0) for name in export.input_names}
    values |= dict.fromkeys(optional_inputs(), export.precision.literal(math.nan)) | {"dt": f"{export.upper}_PERIOD"}
    lines = [f"    .{c_name(name)} = {value}," for name, value in values.items()]
    head = f"{export.prefix}_Inputs {export.prefix}_default_inputs(void)"
    return _function(head, [f"return ({export.prefix}_Inputs){{", *lines, "};"])


def _step(export: Export) -> str:
    prefix, result = export.prefix, export.step.result
    assert isinstance(result, Record)
    output, state = (name for name, _ in result.fields)
    tests = [f"!isfinite(inputs->{c_name(name)})" for name in export.input_names if name not in unchecked_inputs()]
    tests.append(f"inputs->dt <= {export.precision.literal(0.0)}")
    given = "inputs" if passed_by_pointer(export.inputs) else "*inputs"
    lines = [f"if ({' || '.join(tests)}) {{", f"    return {export.upper}_BAD_INPUT;", "}"]
    lines += [BIND] if arrays_of(export.state_leaves) else []
    call = f"{export.step.name}({', '.join([*_passed(export, 'controller->state'), given])})"
    lines += [
        f"const {export.unit.c_type(result)} result = {call};",
        f"controller->state = result.{state};",
        f"*output = result.{output};",
        f"return {export.upper}_OK;",
    ]
    arguments = f"{prefix}_Controller *controller, const {prefix}_Inputs *inputs, {prefix}_Output *output"
    return _function(f"int {prefix}_step({arguments})", lines)


def _regressors(export: Export) -> str:
    """Return the function that takes further known regressors, as a controller in Python does."""
    if export.regressors is None:
        return ""
    prefix, upper, real = export.prefix, export.upper, export.precision.real
    largest = export.precision.literal(LARGEST_REGRESSOR)
    loop = f"for (int i = 0; i < {upper}_REGRESSORS; i++) {{"
    lines = [
        loop,
        f"    if (isfinite(regressors[i]) && (regressors[i] > {largest} || regressors[i] < -{largest})) {{",
        f"        return {upper}_BAD_INPUT;",
        "    }",
        "}",
        loop,
        "    if (isfinite(regressors[i])) {",
        f"        controller->state_arrays.{export.regressors.storage}[i] = regressors[i];",
        "    }",
        "}",
        f"return {upper}_OK;",
    ]
    arguments = f"{prefix}_Controller *controller, const {real} regressors[{upper}_REGRESSORS]"
    return _function(f"int {prefix}_set_regressors({arguments})", lines)


def _switches(export: Export) -> list[str]:
    return [
        _function(
            f"void {export.prefix}_set_{switch.name}({export.prefix}_Controller *controller, bool value)",
            [f"controller->state.{leaf.member} = value;" for leaf in switch.leaves],
        )
        for switch in export.switches
    ]
