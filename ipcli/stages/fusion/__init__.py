"""Commands of depth fusion (thesis chapter 4)."""
