from .flight_queue import CampaignProgress as CampaignProgress
from .fly_campaign import Outcome as Outcome
from .fly_campaign import report_campaign as report_campaign
from .fly_campaign import run_campaign as run_campaign
from .reading import load_spec as load_spec
from .spec import CampaignSpec as CampaignSpec
from .tuning.tune_gains import tune as tune
from .tuning.verdict import TuneOutcome as TuneOutcome
