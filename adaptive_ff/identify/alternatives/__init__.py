"""What else than the chosen model may explain a log."""
