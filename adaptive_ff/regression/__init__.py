"""Equations made from signals: filters, torque form, sliding gate, series (4)."""
