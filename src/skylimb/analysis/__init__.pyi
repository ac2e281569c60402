from .figures import write_figures as write_figures
from .output import write_comparison as write_comparison
from .output import write_report as write_report
from .output import write_run as write_run
from .video import find_renderer as find_renderer
from .video import write_video as write_video
from .videos import write_videos as write_videos
