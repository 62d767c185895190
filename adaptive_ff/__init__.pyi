from .adaptive.controller import AdaptiveController as AdaptiveController
from .comparison.baseline import read_baseline as read_baseline
from .comparison.comparison import Comparison as Comparison
from .comparison.comparison import compare as compare
from .comparison.gate import assert_no_regression as assert_no_regression
from .comparison.gate import regressions as regressions
from .comparison.own import OwnController as OwnController
from .comparison.run import Run as Run
from .comparison.run import simulate as simulate
from .errors import InputError as InputError
from .export.in_c import run_in_c as run_in_c
from .export.project import export_controller as export_controller
from .identify.batch import identify_series as identify_series
from .identify.batch import identify_torque_form as identify_torque_form
from .identify.identification import identify_log as identify_log
from .identify.result import LogIdentification as LogIdentification
from .logs.log import Log as Log
from .logs.log import read_log as read_log
from .model.friction import PER_DIRECTION as PER_DIRECTION
from .model.friction import WITH_OFFSET as WITH_OFFSET
from .model.friction import TorqueModel as TorqueModel
from .scenario.scenario import Scenario as Scenario
from .scenario.scenario import load_scenario as load_scenario
from .scenario.scenario import parse_scenario as parse_scenario
from .stribeck.fit import fit_stribeck as fit_stribeck
from .stribeck.points import support_points as support_points

__version__: str
