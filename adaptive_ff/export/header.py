"""The header of an exported controller: structs, and what can be done with one."""

from importlib.metadata import version

from adaptive_ff.adaptive.arguments import LARGEST_REGRESSOR
from adaptive_ff.export.buffer import HEADER
from adaptive_ff.export.export import Export
from adaptive_ff.export.rendering import rendered
from adaptive_ff.export.sample import optional_inputs, unchecked_inputs
from adaptive_ff.export.tables import arrays_of, arrays_struct
from adaptive_ff.export.units import estimate_unit
from controllers.kernels.comments import block_comment, joined


def header(export: Export) -> str:
    """Return the header."""
    prefix, upper = export.prefix, export.upper
    use = rendered(
        "header_comment.txt",
        title=export.title,
        version=version("adaptive-ff"),
        cls=type(export.controller).__name__,
        prefix=prefix,
    )
    real = export.precision.real
    return joined(
        [
            block_comment(use)
            + f"#ifndef {upper}_H\n#define {upper}_H\n\n"
            + "#include <stdbool.h>\n#include <stddef.h>\n#include <stdint.h>\n\n"
            + '#ifdef __cplusplus\nextern "C" {\n#endif\n',
            f"/* What functions return: zero for success. */\n#define {upper}_OK 0\n"
            f"#define {upper}_BAD_INPUT 1 /* an input is not allowed: controller and output stay as they were */\n"
            f"#define {upper}_BAD_STATE 2 /* a buffer holds no state of this controller, or is too small */\n",
            f"#define {upper}_PERIOD {export.precision.literal(export.controller.period)} /* nominal period, s */\n"
            f"#define {upper}_STATE_SIZE {HEADER.size + export.payload_size} /* bytes of a saved state */\n",
            *(struct.text for struct in export.public_structs),
            _regressor_count(export),
            arrays_struct(export, f"{prefix}_StateArrays", "Arrays of the state.", export.state_leaves),
            _controller(export),
            _functions(export),
            _estimates(export, real),
            f"#ifdef __cplusplus\n}}\n#endif\n\n#endif /* {upper}_H */\n",
        ]
    )


def _regressor_count(export: Export) -> str:
    if export.regressors is None:
        return ""
    return f"enum {{ {export.upper}_REGRESSORS = {export.regressors.count} /* further known regressors */ }};\n"


def _controller(export: Export) -> str:
    prefix = export.prefix
    lines = [f"    {export.unit.c_type(export.state)} state;"]
    if arrays_of(export.state_leaves):
        lines.append(f"    {prefix}_StateArrays state_arrays; /* what pointers above refer to */")
    return (
        "/* A controller: its state, as the settings are constants. */\ntypedef struct {\n"
        + "\n".join(lines)
        + f"\n}} {prefix}_Controller;\n"
    )


def _functions(export: Export) -> str:
    prefix = export.prefix
    finite = ", ".join(name for name in export.input_names if name not in unchecked_inputs())
    parts = [
        (
            "Set the settings, and the state that the controller was exported in.",
            f"void {prefix}_init({prefix}_Controller *controller);",
        ),
        ("Return to the state of a new controller.", f"void {prefix}_reset({prefix}_Controller *controller);"),
        (
            "Begin at standstill with what has been learnt, and forget the motion that the state was saved in: to be "
            "called after init or load_state unless that motion goes on, else the joint is thrown.",
            f"void {prefix}_restart({prefix}_Controller *controller);",
        ),
        (
            f"Return inputs of zero, with dt the nominal period and not known: {', '.join(optional_inputs())}.",
            f"{prefix}_Inputs {prefix}_default_inputs(void);",
        ),
        (
            f"Do one sample. {finite} must be finite and dt positive, else {export.upper}_BAD_INPUT is returned.",
            f"int {prefix}_step({prefix}_Controller *controller, const {prefix}_Inputs *inputs, "
            f"{prefix}_Output *output);",
        ),
        *_taking_regressors(export),
        *(
            (switch.doc, f"void {prefix}_set_{switch.name}({prefix}_Controller *controller, bool value);")
            for switch in export.switches
        ),
        (
            f"Write the state into a buffer of {export.upper}_STATE_SIZE bytes, the same on every machine.",
            f"int {prefix}_save_state(const {prefix}_Controller *controller, unsigned char *buffer, size_t size);",
        ),
        (
            "Restore a saved state; one that is damaged, of another controller, or of one with another period, inertia "
            "or gain, is refused and nothing changes.",
            f"int {prefix}_load_state({prefix}_Controller *controller, const unsigned char *buffer, size_t size);",
        ),
    ]
    return joined([block_comment(doc) + text for doc, text in parts])


def _taking_regressors(export: Export) -> list[tuple[str, str]]:
    if export.regressors is None:
        return []
    prefix, upper = export.prefix, export.upper
    return [
        (
            "Take further known regressors, of the size of one, for the coming steps. Of one that is not finite the "
            f"last one holds; where one is beyond {LARGEST_REGRESSOR:g} in size {upper}_BAD_INPUT is returned and none "
            "is taken.",
            f"int {prefix}_set_regressors({prefix}_Controller *controller, "
            f"const {export.precision.real} regressors[{upper}_REGRESSORS]);",
        )
    ]


def _estimates(export: Export, real: str) -> str:
    names = export.controller.estimate_names
    if not names:
        return ""
    prefix, upper = export.prefix, export.upper
    places = [
        f"    {upper}_{name.upper()},{f' /* {estimate_unit(name)} */' if estimate_unit(name) else ''}" for name in names
    ]
    return joined(
        [
            "/* Places of the physical estimates. */\nenum {\n"
            + "\n".join(places)
            + f"\n    {upper}_ESTIMATES /* how many there are */\n}};\n",
            "/* Return the name of an estimate by its place; NULL where there is none. */\n"
            f"const char *{prefix}_estimate_name(int place);",
            "/* Write all physical estimates. */\n"
            f"void {prefix}_estimates(const {prefix}_Controller *controller, {real} estimates[{upper}_ESTIMATES]);",
        ]
    )
