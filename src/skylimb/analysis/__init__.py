"""Metrics, figures, video and report of recorded flights.

What it is for: it reads runs and nothing else, so that a real flight's log is as welcome as a simulated one.
The names of `__init__.pyi` are loaded when they are first used: scoring a flight should not pay for drawing
it.

Where to start reading: `recording.run` (the record of a flight), `scores.score` (a score, declared at the
function that computes it), `scores.verdict` (done as commanded, or not), `figures.report_figures` (the
report's figures), `report.output` (a run's folder), `viewer.page` (the page that plays it),
`exchange.convert` (other tools' logs), `paper` (what the paper prints), `notebook_run` (a run that draws
itself).

It may import `base`, and `exchange` of it `robots` too, as bags of the lab have frames that only a robot's
model knows. Of whoever flies it knows nothing.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
