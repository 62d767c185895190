"""Velocity of a joint from the readings of an encoder."""
