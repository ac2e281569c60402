from .prior import Prior as Prior
from .prior import load_prior as load_prior
from .reproduce import Reproduction as Reproduction
from .reproduce import reproduce as reproduce
from .result import Result as Result
