"""Component-wise modelling of articulated objects from part masks (thesis chapter 6)."""
