"""Studies that help to design a loop: bandwidth, exciting motions, commissioning."""
