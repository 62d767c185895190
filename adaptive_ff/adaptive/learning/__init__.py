"""What is identified while the joint works, and what of it is fed forward."""
