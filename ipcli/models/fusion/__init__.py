"""Confidence-driven TGV fusion of depth maps (thesis chapter 4).

In reading order: `parameters` (what can be chosen), `reprojection` (4.34), `observations` (what each pixel saw, in
units of its noise), `confidence` (4.35, 4.37), `alternation` (Algorithms 4.1, 4.2, 4.4), `reassociation` (observations
by the map), `edges` (where the surface jumps), `fuse` (all of it), `metrics`, `merge` (several fused maps as one
cloud).
"""
