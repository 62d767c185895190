"""Measured machines: identification, replay and closed loop over recorded data."""
