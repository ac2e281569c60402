"""Everything that can be set or scored, in one list: `show`, `keys`, docs and editors are made from it."""
