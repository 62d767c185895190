"""Every experiment of Ruderman 2013 in simulation: ``python -m benchmarks.paper``."""
