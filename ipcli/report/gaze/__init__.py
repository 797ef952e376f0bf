"""Pages of the gaze kinds."""
