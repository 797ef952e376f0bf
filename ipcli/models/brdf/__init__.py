"""The surface of a shiny object from one picture (thesis chapter 7): all its mathematics, on arrays."""
