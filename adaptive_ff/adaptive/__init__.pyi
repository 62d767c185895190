from .controller import AdaptiveController as AdaptiveController
