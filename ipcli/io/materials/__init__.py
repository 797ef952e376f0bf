"""Readers of materials and light probes."""
