"""What sensor and drive do not tell."""
