"""Friction laws on a measured presliding record, and drawn as force over displacement."""
