"""Five vision problems solved by regularisation and Bayesian inference. Importing the package imports nothing else."""

__version__ = "0.1.0"
