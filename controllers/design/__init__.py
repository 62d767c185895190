"""Design of loops and observers: margins, gains. Not needed on a robot."""
