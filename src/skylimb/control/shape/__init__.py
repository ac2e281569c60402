"""What the arm does with the contact force."""
