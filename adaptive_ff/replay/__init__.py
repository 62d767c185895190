"""Replay of a recorded log by the filter of the adaptive controller."""
