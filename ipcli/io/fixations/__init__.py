"""Readers of pictures and surfaces with recorded fixations."""
