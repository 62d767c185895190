"""Controllers for machines: C99 source translated from the kernels, FMUs around it, and that source behind Python."""
