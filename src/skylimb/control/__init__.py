"""The controller: what it knows (estimation), what it should do (missions), and the laws that do it.

    mission -> reference                                     one row for every tick, known before take-off
    measurement -> estimation -> contact -> shape -> translation -> attitude -> allocation -> command

Read first `cascade`, whose `step` is the whole controller, then `laws`, which says what a law of each slot
has to have, and one law, such as `translation/laws/impedance`. Each slot is a room: its laws are a file each
in `laws`, beside what they are made of. A preset (`presets/*.toml`) names a law for each slot and its gains;
a user's file may take the place of a law (`laws.user_functions`) or of the whole controller
(`laws.user_controller`).

Laws are plain functions of records (`records`, `estimation.records`), written once with `skylimb.symbolic`:
they run on numbers in a test and on CasADi's symbols in the compiled tick (`laws.traced_step`). `laws.fields`
says which fields of the records a law gives and needs, `laws.monitor` holds it to that. `planning` finds
paths, postures and vectoring angles, `loop` flies a controller tick by tick on any vehicle.

Imports `skylimb.robots` and `skylimb.base`, and no simulator: it flies with NumPy and CasADi alone
(`tests/test_core_alone.py`).
"""
