"""Show the arm a job once, and let it repeat it: demonstrations, their clean-up, and their replay with force held."""
