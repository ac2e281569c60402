"""The call that users make: a campaign from its file, or from a spec at hand, flown into a folder."""

from __future__ import annotations

import dataclasses
from pathlib import Path

from skylimb.studies.campaign.flight_queue import Report
from skylimb.studies.campaign.fly_campaign import Outcome, run_campaign
from skylimb.studies.campaign.reading import load_spec
from skylimb.studies.campaign.spec import CampaignSpec


def campaign(
    spec: str | Path | CampaignSpec,
    out: str | Path,
    *,
    calibration: str | Path | None = None,
    workers: int | None = None,
    resume: bool = False,
    scheduler: str = "",
    slurm: str = "",
    progress: Report | None = None,
) -> Outcome:
    """Fly many draws of an experiment with several controllers, into a folder; or go on with one.

    Call it below `if __name__ == "__main__":`, as worker processes import the file that calls it.

    Args:
        spec: a TOML file, or a spec at hand.
        out: folder for the results: spec.toml, flights.parquet, summary.json, report.html and logs/.
        calibration: a calibration.toml, what the controllers know of their robot; the spec's when None.
        workers: as of `run_campaign`, like all that follows.
        resume: whether `out` may be there already; flights in it are not flown again.
        scheduler: address of a Dask scheduler, to fly there.
        slurm: a SLURM queue, to fly there.
        progress: called with the progress, twice a second or more often.

    Returns:
        The outcome, with the table and its summary; not complete when Ctrl-C stopped it.

    Raises:
        SkylimbError: when it cannot be flown, or the folder cannot be used.
    """
    if not isinstance(spec, CampaignSpec):
        spec = load_spec(spec)
    if calibration is not None:
        spec = dataclasses.replace(spec, calibration=str(calibration))
    return run_campaign(
        spec, out, workers=workers, resume=resume, scheduler=scheduler, slurm=slurm, progress=progress
    )
