"""Saliency (thesis 3.3 to 3.5). Read `surface`, `regions`, `features`, `classifier`, `membranes`, `proto_objects`; then
`scene`, which goes through a recording with them.

Pictures and surfaces with recorded fixations: `metrics`, `boolean_maps`, `channels`, `image_model`, `validation`;
`vertex_features`, `vertex_model`; what both are learnt by, `learning`.
"""
