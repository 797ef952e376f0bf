"""Saliency (thesis 3.3 to 3.5)."""
