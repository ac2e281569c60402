"""Shape laws: what the arm does with the contact force."""
