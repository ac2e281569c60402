"""Many flights, and what they show: postures, calibration, verification, campaigns, reproduction, faults.

What it may import: all wings but `apps`. A study flies with `skylimb.flight` as everybody does and reads runs
with `skylimb.analysis`; it has no flight and no score of its own.

Where to start reading: `campaign.fly_campaign` (draws, queue, table, report), `calibration.public` (from a
flight to parameters with intervals), `verification.suite` (rigs held against mechanics), `planning.task_plan`
(the posture for an experiment), `reproduction.reproduce` (the paper against what it leaves open),
`faults.fly_faults` (what a flight survives).
"""
