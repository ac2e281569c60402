from .figures import write_figures as write_figures
from .report.keeping import KeptFlights as KeptFlights
from .report.output import write_comparison as write_comparison
from .report.output import write_report as write_report
from .report.output import write_run as write_run
from .report.video import find_renderer as find_renderer
from .report.video import write_video as write_video
from .report.videos import write_videos as write_videos
