"""Single precision: how it writes numbers, and the constants that must be others in it."""

import numpy as np

from controllers.kernels.literals import Precision

IN_SINGLE = {"CANDIDATES_LEAST_PRIOR": 1e-6, "CANDIDATE_MOMENTS_LEAST_LEFT": 64.0 * float(np.finfo(np.float32).eps)}
"""Constants of kernels that stand for the rounding of sums, by their names in C: what they are in single precision.

With those of double precision the candidates for the friction curve are chosen by rounding, up to 46 times in 12 s at
20 kHz, each time with the lag that is assumed at first; 1e-5 for the prior holds estimates back at 1 kHz and faster.
"""

SINGLE = Precision("float", "f", IN_SINGLE)
