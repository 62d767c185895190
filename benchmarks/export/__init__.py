"""The exported controllers measured against the kernels: bits, machines, size, speed, single precision."""
