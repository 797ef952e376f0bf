"""Commands of action recognition (thesis chapter 5)."""
