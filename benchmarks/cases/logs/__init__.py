"""Identification of logs: synthetic ones, and those of recorded machines."""
