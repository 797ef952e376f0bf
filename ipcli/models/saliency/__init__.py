"""Saliency (thesis 3.3 to 3.5). Read `surface`, `regions`, `features`, `classifier`, `membranes`, `proto_objects`; then
`scene`, which goes through a recording with them.
"""
