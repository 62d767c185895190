from .controller import AdaptiveController as AdaptiveController
from .group import JointGroup as JointGroup
from .tuning import Tuning as Tuning
