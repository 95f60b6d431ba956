"""What the arm is: kinematics, dynamics, friction, and the tool in its hand."""
