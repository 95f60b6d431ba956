"""Recordings: written beside the loop, mended, read, compared, and handed on."""
