"""Recorded logs: file formats, columns, defects, derivatives."""
