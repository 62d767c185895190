"""Machines in MuJoCo."""
