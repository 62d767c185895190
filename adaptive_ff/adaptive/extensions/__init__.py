"""What plugs into the adaptive controller: columns over position and load, and the coupling of joints in a chain."""
