from .folder import load_runs as load_runs
from .origin import write_sources as write_sources
from .run import FORMAT_VERSION as FORMAT_VERSION
from .run import LOG_FILE as LOG_FILE
from .run import Run as Run
