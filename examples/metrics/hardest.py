"""A metric of your own."""

import skylimb


@skylimb.metric(unit="N", smaller_is_better=True)
def hardest(run):
    """Largest normal force."""
    return float(run.log.contact_force_normal.max())
