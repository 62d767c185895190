"""The language in which kernels are written, and its translation to machine code."""
