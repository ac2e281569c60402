"""From a wanted force and torque to thrusts and vectoring angles: laws, and what they are made of."""
