"""What a controller makes of the contact: whether there is one, where its surface leads, how fast to go."""
