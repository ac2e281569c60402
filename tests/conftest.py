"""Settings of all tests."""

from hypothesis import settings

# A test says what is right, not how fast: two cores that fly beside it break any deadline now and then.
settings.register_profile("skylimb", deadline=None)
settings.load_profile("skylimb")
