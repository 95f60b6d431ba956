"""Whether an arm can do a plan, before anything moves: reach, limits, speed, torque and collisions."""
