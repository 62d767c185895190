"""Friction and force over position and load."""
