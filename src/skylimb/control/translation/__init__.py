"""What keeps the centre of gravity: laws, and what more than one of them is made of."""
