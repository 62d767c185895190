"""The static friction curve from quasi-static drives: support points and the fit of Stribeck velocity and shape."""
