from .canudas import CanudasController as CanudasController
from .canudas import CanudasMeasuredController as CanudasMeasuredController
from .feedback_error import FeedbackErrorLearning as FeedbackErrorLearning
from .model_based import ModelBased as ModelBased
from .observed_model import ObservedModel as ObservedModel
from .paper import PaperController as PaperController
