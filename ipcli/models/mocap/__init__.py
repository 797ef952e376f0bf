"""Recognition of actions by the behaviours of the body's parts (thesis chapter 5).

In reading order: `parameters` (what can be chosen), `motions` (what is learnt from and asked about), `features`
(Algorithms 5.1 and 5.2, and what carries over to other people), `projection` (the coordinates the mixtures live in),
`behaviours` (a Dirichlet process mixture for each action and group, 5.8 and 5.9), `training` (all cells, validation,
diagnostics), `preferences` (5.12), `recognition` (5.10, 5.11: frames, clips, unordered frames, windows), `novelty`,
`calibration`, `fold_models` (when it is none of these), `queries` (what is asked of a model), `splits` (who is learnt
from, who is asked), `evaluation` (how often it is right), `left_out` and `open_set` (how often none of these is).
"""
