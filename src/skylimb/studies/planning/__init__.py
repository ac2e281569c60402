"""Studies of one task or posture: the posture for a task, what can be pushed there, and pictures of both."""
