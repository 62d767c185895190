"""Identification of a joint from a recorded log."""
