"""The hypothesis: friction model, possible values of its parameters, and the feedforward computed from it."""
