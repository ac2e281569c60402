"""The moving part of a report: flights in three dimensions, and plots with a common time cursor.

Python packs scene, motion and signals of the flights into one JSON document; a page shows it with three.js
and uPlot, which are bundled into `vendor.js`, by the program in `viewer.js` (sources: `web/` of the
repository). The studio's page loads the same `vendor.js`.
"""

from pathlib import Path

VENDOR = Path(__file__).parent / "vendor.js"
"""three.js and uPlot, which a page needs before its own program."""
