"""The arm in MuJoCo, as dishonest as a real one."""
