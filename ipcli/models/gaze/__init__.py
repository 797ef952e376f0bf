"""Thesis section 3.2: localising the head and the point of regard.

Read in this order: `features` (step 1), `pose` ((3.1)-(3.4)), `scene_map` and `tracking` (the steps frame by frame),
`bundle` and `adjustment` ((3.8)-(3.9)), `localise` (a whole path), `surface` and `regard` (points of regard), `gric`
and `attention` ((3.5)-(3.7), subsequences), `fixations`, `experiment` ((3.34)), `evaluation`, `checks`, `dense`.
"""
