"""Random tasks with random faults on the simulated arm, each judged by what the arm really did."""
