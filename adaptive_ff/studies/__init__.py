"""Experiments over many cases: one engine for cases x controllers x seeds, and the studies that use it."""
