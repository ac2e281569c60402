"""The physical side: plant, surfaces, sensors, actuators, and the loop that closes around a controller."""
