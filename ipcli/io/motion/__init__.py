"""Readers of motion capture; `layouts` is the table of them."""
