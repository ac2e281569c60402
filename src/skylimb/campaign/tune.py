"""Search."""


class TuneOutcome:
    """Placeholder."""


def tune() -> None:
    """Placeholder."""
