"""What the feedforward leaves, and how far it is trusted."""
