"""Flights: from an experiment and a controller to a run.

A plan is made and checked, a vehicle is put under it, a driver flies it tick by tick, and its record
becomes a run. May import simulation, control, analysis, robots and base; what flies a real robot imports
no simulator.

Where to start reading:

- `public`: the calls of users. `loading` turns names into plans.
- `plan`: all that is known before take-off. `feasible` and `flyable` say what is refused, `derived` keeps
  what was computed.
- `takeoff`: a plan with its simulated plant. `flying` chooses the driver and flies; `stepped` is by hand.
- `flight_run`: any flight as a run. `simulated_run` adds truth, `run_files` the user's files.

Rooms: `experiments` (what is flown), `events` (what happens to a flight besides), `drivers` (three ways to
fly a tick, with the same bits), `realtime` (on the wall clock, and a robot behind a link; `decision` is the
guard's table), `replay` (a log through a controller again), `export` (a controller as C).
"""
