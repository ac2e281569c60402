"""The moving part of a report: flights in three dimensions, and plots with a common time cursor.

Python packs scene, motion and signals of the flights into one JSON document; a page shows it with three.js
and uPlot, which are bundled into `viewer.js` (sources: `web/` of the repository).
"""
