"""Functions in C that write a state into a buffer and read it; the format is that of ``buffer``."""

from adaptive_ff.export.buffer import HEADER, MAGIC, VERSION
from adaptive_ff.export.export import Export
from adaptive_ff.export.leaves import Leaf
from adaptive_ff.export.tables import has_arrays
from controllers.kernels.types import BOOLEAN, INTEGER, REAL

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
#define MAGIC UINT32_C(0x{magic:08x}) /* the letters AFFS */
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
    put(buffer, MAGIC, 4);
    put(buffer + 4, FORMAT_VERSION, 4);
    put(buffer + 8, {P}_STATE_SIZE, 4);
    put(buffer + 12, checksum(buffer + HEADER_SIZE, {P}_STATE_SIZE - HEADER_SIZE), 4);
    put(buffer + 16, LAYOUT_HASH, 8);
    return {P}_OK;
}}

int {p}_load_state({p}_Controller *controller, const unsigned char *buffer, size_t size)
{{
    if (size != {P}_STATE_SIZE || get(buffer, 4) != MAGIC || get(buffer + 4, 4) != FORMAT_VERSION
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
        magic=int.from_bytes(MAGIC, "little"),
        hash=export.hash,
        real=export.precision.real,
        bits="uint32_t" if export.single else "uint64_t",
        p=export.prefix,
        P=export.upper,
        bind="bind(controller);\n    " if has_arrays(export) else "",
    )


def _place(leaf: Leaf) -> str:
    return f"state_arrays.{leaf.storage}" if leaf.is_array else f"state.{leaf.member}"
