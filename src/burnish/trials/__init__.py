"""Trials of laws on simulated arms: what one is, how it is run, its figures, its page."""
