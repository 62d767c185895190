"""What a kernel may contain, and its translation to C."""
