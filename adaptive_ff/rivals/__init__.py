"""Rivals that feed forward or identify."""

from adaptive_ff.rivals.model_based import ModelBased
from adaptive_ff.rivals.paper import PaperController

__all__ = ["ModelBased", "PaperController"]
