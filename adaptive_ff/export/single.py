"""Single precision: how it writes numbers."""

from controllers.kernels.literals import Precision

SINGLE = Precision("float", "f")
