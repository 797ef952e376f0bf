"""Regularisation: operators and their dot test, proximal maps, the primal-dual method, total (generalised) variation.

The regulariser (`tgv`) and the data term (`fidelity`) know nothing of each other: a chapter with another data term
writes one class with the methods of `fidelity.Fidelity` and calls `tgv.minimise`.
"""
