"""Stages of the gaze commands (thesis section 3.2)."""
