"""Readers of head-mounted recordings and of gaze exports, and the writers of what other programs read."""
