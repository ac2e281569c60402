from .analysis.own import figure as figure
from .analysis.own import metric as metric
from .calibration.public import calibrate as calibrate
from .campaign.sweep import sweep as sweep
from .control.controller import Controller as Controller
from .control.controller import load_controller as load_controller
from .control.records import Command as Command
from .descriptions.checking import check_robot_file as check_robot_file
from .descriptions.writing import import_robot as import_robot
from .errors import SkylimbError as SkylimbError
from .estimation.records import Measurement as Measurement
from .experiments.experiment import Experiment as Experiment
from .experiments.experiment import load_experiment as load_experiment
from .experiments.listing import list_controllers as list_controllers
from .experiments.listing import list_experiments as list_experiments
from .flights.public import begin as begin
from .flights.public import compare as compare
from .flights.public import run as run
from .flights.replay.replay import replay as replay
from .missions.reference import Reference as Reference
from .recording.folder import load_runs as load_runs
from .recording.run import Run as Run
from .robots.loader import list_robots as list_robots
from .robots.loader import load_robot as load_robot
from .robots.model import Robot as Robot
from .signals import Signal as Signal

__version__: str
