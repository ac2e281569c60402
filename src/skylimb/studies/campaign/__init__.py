"""Many flights: what varies, a queue that survives kills, a table, and what the table says.

    from skylimb.studies.campaign import run_campaign

    if __name__ == "__main__":  # worker processes import this file
        outcome = run_campaign("campaign.toml", "out/campaign")

How a campaign runs, from top to bottom:

    campaign.toml
        | reading, spec, distributions        every key checked
        v
    CampaignSpec
        | frozen                              experiment, presets and versions resolved; spec.toml
        v
    Campaign ----> draws                      draw i: a pure function of spec and i
        |
        | fly_campaign: jobs of all draws     tuning: jobs of the gains that a search tries
        v                                         |
    flight_queue <--------------------------------+
        |   ^                     jobs out, rows and logs back; a dead worker's jobs fly again
        v   |
    engines: inline | local processes | cluster (Dask, on SLURM too)
        |   ^
        v   |
    worker.fly_jobs                           in the worker: one job -> one row
        | unchanged                           by the files that the campaign was begun with
    ...
    store                                     flights.sqlite while it flies, flights.parquet at the end
        | statistics, stopping                enough? else the next jobs
        v
    summary -> summary.json, report -> report.html

The names of `__init__.pyi` are loaded at their first use: a worker does not load what draws the report.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
