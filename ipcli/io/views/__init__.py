"""Readers of depth maps with cameras; `layouts` is the table of them."""
