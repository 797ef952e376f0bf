"""Formats of files; atomic.py is the only writer."""
