"""What all other wings stand on: errors, configuration, packed records, rotations, files and users' code.

- `errors`: the one family of errors, and messages that name the nearest right name. Read it first.
- `keys`, `config`: a configuration is a frozen dataclass whose fields carry unit, range and meaning. It
  checks itself, and is read from TOML and written to it.
- `packing`: records of named arrays to flat vectors and back.
- `rotations`: on NumPy arrays and CasADi symbols alike, as everything in `skylimb.symbolic`.
- `bound_function`, `c_code`: CasADi functions on NumPy arrays' own memory, and as C.
- `files`, `sources`: writing that leaves nothing half done, reading that remembers what was read.
- `user_modules`, `user_code`: a user's Python files, and errors in them described in one line.
- `signals`, `statics`: what a recorded signal is; a robot at rest that pushes.

Imports nothing of skylimb but `skylimb.symbolic`, and of others NumPy and CasADi alone (tomli-w to write).
"""
