"""Rivals that feed forward or identify."""

from adaptive_ff.rivals.canudas import CanudasController, CanudasMeasuredController
from adaptive_ff.rivals.feedback_error import FeedbackErrorLearning
from adaptive_ff.rivals.model_based import ModelBased
from adaptive_ff.rivals.paper import PaperController

__all__ = ["CanudasController", "CanudasMeasuredController", "FeedbackErrorLearning", "ModelBased", "PaperController"]
