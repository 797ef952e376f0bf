"""Bayesian inference: Dirichlet process mixtures of Gaussians with learned hyperparameters (thesis 2.5, 5.4).

fitted = mixture.fit(x, parameters.Mixture(), rng)     # x (n, d), any d
fitted.predictive.log_density(frames)                  # averaged over the kept sweeps of all chains
fitted.labels(), fitted.behaviours()                   # one partition of the points, and its components
fitted.cluster_counts()                                # posterior of the number of clusters
"""
