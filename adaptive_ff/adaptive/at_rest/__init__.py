"""A joint at rest, or behind a position loop."""
