"""Long runs: a week of everything that a joint meets, and an hour without excitation."""
