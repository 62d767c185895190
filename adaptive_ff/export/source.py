"""The source of an exported controller: constants, translated kernels, and the functions of the header."""

from adaptive_ff.export.buffer import HEADER, VERSION
from adaptive_ff.export.comments import block_comment, joined, plain, summary
from adaptive_ff.export.export import Export
from adaptive_ff.export.kernels import Constant
from adaptive_ff.export.leaves import Leaf
from adaptive_ff.export.sample import optional_inputs, unchecked_inputs
from adaptive_ff.export.scope import c_name
from adaptive_ff.export.tables import array_table, arrays_of, record_table
from adaptive_ff.export.types import BOOLEAN, INTEGER, REAL

GUARD = """#if defined(__FAST_MATH__) || defined(_M_FP_FAST) || (defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__)
#error "fast-math drops the tests for what is not a number, on which this controller depends: compile without it"
#endif
"""

CONTRACTION = """#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#endif
"""

HELPERS = {
    "square": "static {real} square({real} value)\n{{\n    return value * value;\n}}\n",
    "larger": "static {real} larger({real} first, {real} second)\n{{\n    return second > first ? second : first;\n}}\n",
    "smaller": "static {real} smaller({real} first, {real} second)\n{{\n    return second < first ? second : first;\n}}\n",
    "larger_integer": "static int64_t larger_integer(int64_t first, int64_t second)\n"
    "{{\n    return second > first ? second : first;\n}}\n",
    "smaller_integer": "static int64_t smaller_integer(int64_t first, int64_t second)\n"
    "{{\n    return second < first ? second : first;\n}}\n",
}
"""Of equal values, and beside what is not a number, the first one is taken, as in Python."""


def source(export: Export) -> str:
    """Return the source."""
    kernels = _kernels(export)  # first: it says which constants and helpers there are
    public = len(export.public_structs)
    parts = [
        f'/* {plain(export.title)} See {export.prefix}.h. */\n#include "{export.prefix}.h"\n',
        "#include <math.h>\n#include <string.h>\n",
        GUARD,
        CONTRACTION,
        _constants(export),
        *(struct.text for struct in list(export.unit.structs.values())[public:]),
        *(HELPERS[name].format(real=export.precision.real) for name in sorted(export.unit.helpers)),
        kernels,
        _tables(export),
        _bind(export),
        _starting(export),
        _default_inputs(export),
        _step(export),
        *_switches(export),
        state_buffer(export),
        _estimates(export),
    ]
    return joined(parts)


def _constants(export: Export) -> str:
    lines = []
    for name, constant in sorted(export.unit.constants.items()):
        lines += block_comment(constant.doc).splitlines() if constant.doc else []
        lines += _definitions(export, name, constant)
    return "\n".join(lines)


def _definitions(export: Export, name: str, constant: Constant) -> list[str]:
    values = constant.value if isinstance(constant.value, tuple) else None
    pairs = [(name, constant.value)] if values is None else [(f"{name}_{i}", item) for i, item in enumerate(values)]
    texts = [(key, export.precision.literal(item, key)) for key, item in pairs]
    return [f"#define {key} {f'({text})' if text.startswith('-') else text}" for key, text in texts]


def _kernels(export: Export) -> str:
    parts, last, seen = [], "", set()
    for function in export.unit.functions.values():
        kernel = function.kernel
        if kernel.path != last:
            last = kernel.path
            module = __import__(kernel.function.__module__, fromlist=["_"])
            text = f"---- {kernel.path}" if last in seen else f"---- {kernel.path}\n\n{summary(module)}"
            seen.add(last)
            parts.append(block_comment(text))
        parts.append(function.text)
    return joined(parts)


def _tables(export: Export) -> str:
    """Return settings and states as constants; the state of a new controller once where it is the one to start in."""
    start, fresh = export.controller.state, export.fresh.state
    parts = [record_table(export, "PARAMETERS", export.parameters, export.controller.parameters)]
    if arrays_of(export.parameter_leaves):
        struct = f"{export.prefix}_ParameterArrays"
        found = export.parameter_leaves
        parts.append(array_table(export, struct, "PARAMETER_ARRAYS", found, export.controller.parameters))
    for name, value in (("NEW", fresh), ("START", start)):
        parts.append(record_table(export, f"{name}_STATE", export.state, value))
        if arrays_of(export.state_leaves):
            struct = f"{export.prefix}_StateArrays"
            parts.append(array_table(export, struct, f"{name}_STATE_ARRAYS", export.state_leaves, value))
    if [part.replace("START_", "NEW_") for part in parts[-2:]] == parts[-4:-2]:
        del parts[-2:]
    elif not arrays_of(export.state_leaves) and parts[-1].replace("START_", "NEW_") == parts[-2]:
        del parts[-1:]
    return joined(parts)


def _bind(export: Export) -> str:
    lines = [
        f"controller->{owner}.{leaf.member} = controller->{arrays}.{leaf.storage};"
        for owner, arrays, found in (
            ("parameters", "parameter_arrays", export.parameter_leaves),
            ("state", "state_arrays", export.state_leaves),
        )
        for leaf in arrays_of(found)
    ]
    if not lines:
        return ""
    return (
        "/* Let the arrays of parameters and state be those of this controller, which may be a copy of another. */\n"
        f"static void bind({export.prefix}_Controller *controller)\n{{\n    " + "\n    ".join(lines) + "\n}\n"
    )


def has_arrays(export: Export) -> bool:
    """Tell whether parameters or state hold arrays."""
    return bool(arrays_of(export.parameter_leaves) or arrays_of(export.state_leaves))


def _starting(export: Export) -> str:
    prefix, arrays = export.prefix, bool(arrays_of(export.state_leaves))
    start = "START" if "START_STATE" in _tables(export) else "NEW"
    init = ["controller->parameters = PARAMETERS;"]
    init += ["controller->parameter_arrays = PARAMETER_ARRAYS;"] if arrays_of(export.parameter_leaves) else []
    init += [f"controller->state = {start}_STATE;"]
    init += [f"controller->state_arrays = {start}_STATE_ARRAYS;"] if arrays else []
    reset = ["controller->state = NEW_STATE;"]
    reset += ["controller->state_arrays = NEW_STATE_ARRAYS;"] if arrays else []
    ending = ["bind(controller);"] if has_arrays(export) else []
    return joined(
        [
            _function(f"void {prefix}_init({prefix}_Controller *controller)", [*init, *ending]),
            _function(f"void {prefix}_reset({prefix}_Controller *controller)", [*reset, *ending]),
        ]
    )


def _function(head: str, lines: list[str]) -> str:
    return f"{head}\n{{\n    " + "\n    ".join(lines) + "\n}\n"


def _default_inputs(export: Export) -> str:
    values = {name: export.precision.literal(0.0) for name in export.input_names}
    values |= dict.fromkeys(optional_inputs(), "NAN") | {"dt": f"{export.upper}_PERIOD"}
    lines = [f"    .{c_name(name)} = {value}," for name, value in values.items()]
    return _function(
        f"{export.prefix}_Inputs {export.prefix}_default_inputs(void)",
        [f"return ({export.prefix}_Inputs){{", *lines, "};"],
    )


def _step(export: Export) -> str:
    prefix = export.prefix
    result = export.step.result
    assert result is not None
    output, state = (name for name, _ in result.fields)  # type: ignore[union-attr]
    checked = [name for name in export.input_names if name not in unchecked_inputs()]
    tests = [f"!isfinite(inputs->{c_name(name)})" for name in checked]
    tests.append(f"inputs->dt <= {export.precision.literal(0.0)}")
    arguments = [
        f"{'' if value.startswith('*') else '&'}{value.lstrip('*')}"
        if unit_by_pointer
        else (value if not value.startswith("*") else value)
        for value, unit_by_pointer in (
            ("controller->parameters", _by_pointer(export, "parameters")),
            ("controller->state", _by_pointer(export, "state")),
            ("*inputs", _by_pointer(export, "inputs")),
        )
    ]
    lines = [f"if ({' || '.join(tests)}) {{", f"    return {export.upper}_BAD_INPUT;", "}"]
    lines += ["bind(controller);"] if has_arrays(export) else []
    lines += [
        f"const {export.unit.c_type(result)} result = {export.step.name}({', '.join(arguments)});",  # type: ignore[arg-type]
        f"controller->state = result.{state};",
        f"*output = result.{output};",
        f"return {export.upper}_OK;",
    ]
    head = f"int {prefix}_step({prefix}_Controller *controller, const {prefix}_Inputs *inputs, {prefix}_Output *output)"
    return _function(head, lines)


def _by_pointer(export: Export, name: str) -> bool:
    from adaptive_ff.export.types import passed_by_pointer

    return passed_by_pointer(getattr(export, name))


def _switches(export: Export) -> list[str]:
    return [
        _function(
            f"void {export.prefix}_set_{switch.name}({export.prefix}_Controller *controller, bool value)",
            [f"controller->state.{leaf.member} = value;" for leaf in switch.leaves],
        )
        for switch in export.switches
    ]


def _estimates(export: Export) -> str:
    names, prefix, upper = export.controller.estimate_names, export.prefix, export.upper
    if export.write_estimates is None:
        return ""
    listed = [f'"{name}",' for name in names]
    arguments = [f"&own.{part}" if _by_pointer(export, part) else f"own.{part}" for part in ("parameters", "state")]
    body = [f"{prefix}_Controller own = *controller;"]
    body += ["bind(&own);"] if has_arrays(export) else []
    body += [f"{export.write_estimates.name}({', '.join(arguments)}, estimates);"]
    return joined(
        [
            _function(
                f"const char *{prefix}_estimate_name(int place)",
                [
                    f"static const char *const names[{upper}_ESTIMATES] = {{",
                    *(f"    {line}" for line in listed),
                    "};",
                    f"return place >= 0 && place < {upper}_ESTIMATES ? names[place] : NULL;",
                ],
            ),
            _function(
                f"void {prefix}_estimates(const {prefix}_Controller *controller, "
                f"{export.precision.real} estimates[{upper}_ESTIMATES])",
                body,
            ),
        ]
    )


BUFFER = """/* A number, or an array of them, of the state: where it is, how many there are, of which kind. */
typedef struct {{
    size_t offset;
    size_t count;
    enum {{ REAL, INTEGER, BOOLEAN }} kind;
}} Field;

static const Field FIELDS[] = {{
{fields}
}};

#define FIELD_COUNT (sizeof FIELDS / sizeof FIELDS[0])
#define HEADER_SIZE {header}u
#define FORMAT_VERSION {version}u
#define LAYOUT_HASH UINT64_C(0x{hash:016x})

/* FNV-1a, 32 bits. */
static uint32_t checksum(const unsigned char *bytes, size_t size)
{{
    uint32_t sum = 2166136261u;
    for (size_t i = 0; i < size; i++) {{
        sum = (sum ^ bytes[i]) * 16777619u;
    }}
    return sum;
}}

static void put(unsigned char *bytes, uint64_t value, size_t width)
{{
    for (size_t i = 0; i < width; i++) {{
        bytes[i] = (unsigned char)(value >> (8 * i) & 0xffu);
    }}
}}

static uint64_t get(const unsigned char *bytes, size_t width)
{{
    uint64_t value = 0;
    for (size_t i = 0; i < width; i++) {{
        value |= (uint64_t)bytes[i] << (8 * i);
    }}
    return value;
}}

/* Bytes of a number in a buffer. */
static size_t width_of(const Field *field)
{{
    return field->kind == BOOLEAN ? 1 : field->kind == INTEGER ? 8 : sizeof({real});
}}

/* Number of a controller as the bits that a buffer holds. */
static uint64_t bits_of(const unsigned char *place, const Field *field, size_t i)
{{
    {bits} real_bits;
    int64_t integer;
    bool truth;
    switch (field->kind) {{
    case REAL:
        memcpy(&real_bits, place + i * sizeof real_bits, sizeof real_bits);
        return real_bits;
    case INTEGER:
        memcpy(&integer, place + i * sizeof integer, sizeof integer);
        return (uint64_t)integer;
    default:
        memcpy(&truth, place + i * sizeof truth, sizeof truth);
        return truth ? 1u : 0u;
    }}
}}

/* Set a number of a controller; false where it is none. */
static bool set_bits(unsigned char *place, const Field *field, size_t i, uint64_t bits)
{{
    const {bits} real_bits = ({bits})bits;
    {real} real;
    int64_t integer;
    const bool truth = bits != 0u;
    switch (field->kind) {{
    case REAL:
        memcpy(&real, &real_bits, sizeof real);
        memcpy(place + i * sizeof real, &real, sizeof real);
        return !isnan(real);
    case INTEGER:
        memcpy(&integer, &bits, sizeof integer);
        memcpy(place + i * sizeof integer, &integer, sizeof integer);
        return true;
    default:
        memcpy(place + i * sizeof truth, &truth, sizeof truth);
        return bits <= 1u;
    }}
}}

int {p}_save_state(const {p}_Controller *controller, unsigned char *buffer, size_t size)
{{
    if (size < {P}_STATE_SIZE) {{
        return {P}_BAD_STATE;
    }}
    unsigned char *next = buffer + HEADER_SIZE;
    for (size_t f = 0; f < FIELD_COUNT; f++) {{
        const unsigned char *place = (const unsigned char *)controller + FIELDS[f].offset;
        for (size_t i = 0; i < FIELDS[f].count; i++) {{
            put(next, bits_of(place, &FIELDS[f], i), width_of(&FIELDS[f]));
            next += width_of(&FIELDS[f]);
        }}
    }}
    memcpy(buffer, "AFFS", 4);
    put(buffer + 4, FORMAT_VERSION, 4);
    put(buffer + 8, {P}_STATE_SIZE, 4);
    put(buffer + 12, checksum(buffer + HEADER_SIZE, {P}_STATE_SIZE - HEADER_SIZE), 4);
    put(buffer + 16, LAYOUT_HASH, 8);
    return {P}_OK;
}}

int {p}_load_state({p}_Controller *controller, const unsigned char *buffer, size_t size)
{{
    if (size != {P}_STATE_SIZE || memcmp(buffer, "AFFS", 4) != 0 || get(buffer + 4, 4) != FORMAT_VERSION
        || get(buffer + 8, 4) != {P}_STATE_SIZE || get(buffer + 16, 8) != LAYOUT_HASH
        || get(buffer + 12, 4) != checksum(buffer + HEADER_SIZE, {P}_STATE_SIZE - HEADER_SIZE)) {{
        return {P}_BAD_STATE;
    }}
    {p}_Controller restored = *controller;
    const unsigned char *next = buffer + HEADER_SIZE;
    for (size_t f = 0; f < FIELD_COUNT; f++) {{
        unsigned char *place = (unsigned char *)&restored + FIELDS[f].offset;
        for (size_t i = 0; i < FIELDS[f].count; i++) {{
            if (!set_bits(place, &FIELDS[f], i, get(next, width_of(&FIELDS[f])))) {{
                return {P}_BAD_STATE;
            }}
            next += width_of(&FIELDS[f]);
        }}
    }}
    *controller = restored;
    {bind}return {P}_OK;
}}
"""


def state_buffer(export: Export) -> str:
    """Return the functions that write a state into a buffer and read it, as ``buffer`` does in Python."""
    kinds = {REAL: "REAL", INTEGER: "INTEGER", BOOLEAN: "BOOLEAN"}
    lines = [
        f"    {{offsetof({export.prefix}_Controller, {_place(leaf)}), {leaf.count}, {kinds[leaf.kind]}}},"
        for leaf in export.state_leaves
        if leaf.count
    ]
    return BUFFER.format(
        fields="\n".join(lines),
        header=HEADER.size,
        version=VERSION,
        hash=export.hash,
        real=export.precision.real,
        bits="uint32_t" if export.single else "uint64_t",
        p=export.prefix,
        P=export.upper,
        bind="bind(controller);\n    " if has_arrays(export) else "",
    )


def _place(leaf: Leaf) -> str:
    return f"state_arrays.{leaf.storage}" if leaf.is_array else f"state.{leaf.member}"
