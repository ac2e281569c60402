"""The cascade of the paper's block diagram: translation, attitude and shape laws, and thrust allocation."""
