"""A run as a user's metric or figure gets it: to be read, so that others find it as it was."""

from __future__ import annotations

import copy
from dataclasses import replace
from types import MappingProxyType
from typing import TYPE_CHECKING

from skylimb.analysis.recording.run import AnyRun

if TYPE_CHECKING:
    import xarray as xr


def read_only(run: AnyRun) -> AnyRun:
    """The run with scores and signals that cannot be written to; nothing of the log is copied.

    What is put into its log, as a signal or an attribute, is put into this one alone.
    """
    log = run.log.assign({name: _fixed(run.log[name].variable) for name in run.log.data_vars})
    mine = replace(run, log=log, metrics=copy.deepcopy(dict(run.metrics)))
    return replace(mine, metrics=MappingProxyType(mine.metrics))


def _fixed(signal: xr.Variable) -> xr.Variable:
    values = signal.values.view()
    values.flags.writeable = False
    return signal.copy(deep=False, data=values)
