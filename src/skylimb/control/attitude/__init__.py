"""What keeps the attitude, and the target that it follows."""
