"""Stages of chapter 6: animals from part masks."""
