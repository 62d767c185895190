from .controller import AdaptiveController as AdaptiveController
from .controller import UnsupervisedController as UnsupervisedController
