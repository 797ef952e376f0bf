"""The thesis' models, on plain arrays; a folder a chapter."""
