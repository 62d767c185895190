"""One run of a closed loop: experiment, loop, metrics."""
