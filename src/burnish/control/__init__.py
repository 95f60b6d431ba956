"""A reference to a torque: the control laws, and what the tool feels."""
