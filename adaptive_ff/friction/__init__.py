"""The friction hypothesis of this package: which torque a motion needs, as columns of a linear regression."""
