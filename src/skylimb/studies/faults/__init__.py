"""What a flight survives: a catalogue of faults, each flown as a campaign, and the table that comes of it.

    from skylimb.studies.faults import fly_faults

    if __name__ == "__main__":  # worker processes import this file
        outcome = fly_faults("out/faults", draws=20)

`catalogue.toml` holds each fault as data: what happens, the physics in words, and the bounds it is held to.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
