"""The two kinds of mathematics of the thesis: regularisation here, Bayesian inference beside it."""
