"""Functions in C that write a state into a buffer and read it; the format is that of ``buffer``."""

from adaptive_ff.export.buffer import HEADER, MAGIC, VERSION
from adaptive_ff.export.entry_points import BIND
from adaptive_ff.export.export import Export
from adaptive_ff.export.leaves import Leaf
from adaptive_ff.export.rendering import rendered
from adaptive_ff.export.tables import arrays_of
from controllers.kernels.types import BOOLEAN, INTEGER, REAL


def state_buffer(export: Export) -> str:
    """Return the functions that write a state into a buffer and read it, as ``buffer`` does in Python."""
    kinds = {REAL: "REAL", INTEGER: "INTEGER", BOOLEAN: "BOOLEAN"}
    lines = [
        f"    {{offsetof({export.prefix}_Controller, {_place(leaf)}), {leaf.count}, {kinds[leaf.kind]}}},"
        for leaf in export.state_leaves
        if leaf.count
    ]
    return rendered(
        "state.c",
        fields="\n".join(lines),
        header=HEADER.size,
        version=VERSION,
        magic=int.from_bytes(MAGIC, "little"),
        hash=export.hash,
        real=export.precision.real,
        bits="uint32_t" if export.single else "uint64_t",
        p=export.prefix,
        P=export.upper,
        bind=f"{BIND}\n    " if arrays_of(export.state_leaves) else "",
    )


def _place(leaf: Leaf) -> str:
    return f"state_arrays.{leaf.storage}" if leaf.is_array else f"state.{leaf.member}"
