"""A model trained on one log simulates another one from its torque alone."""
