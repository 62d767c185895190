"""Velocity loops with an observer of what disturbs them."""
