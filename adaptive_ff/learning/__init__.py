"""Online and offline least squares: the estimators of this package, and the regressions they solve."""
