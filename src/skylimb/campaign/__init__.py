"""Many flights: a spec, its draws, an engine that survives, a table, and what the table says.

    from skylimb.campaign import run_campaign

    if __name__ == "__main__":  # worker processes import this file
        outcome = run_campaign("campaign.toml", "out/campaign")
"""
