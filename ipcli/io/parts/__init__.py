"""Readers of images whose pixels are labelled by part, and of the project that names them."""
