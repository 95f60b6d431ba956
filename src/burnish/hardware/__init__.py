"""The real arm, a Kinova JACO2: the only home of the vendor's library."""
