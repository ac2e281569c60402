"""The cascade of the paper's block diagram: translation law, attitude law, thrust allocation and shape law."""
