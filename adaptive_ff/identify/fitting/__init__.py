"""Fits of the rows, and which terms of the model a log supports."""
