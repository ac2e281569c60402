from .catalogue import Catalogue as Catalogue
from .catalogue import load_catalogue as load_catalogue
from .fly_faults import Outcome as Outcome
from .fly_faults import fly_faults as fly_faults
