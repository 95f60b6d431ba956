"""The operator's half: devices, shaping of their readings, modes, limits and references."""
