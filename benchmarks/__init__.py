"""Benchmarks: ratios against peers and laws of growth, each measured side by side in one run. See README.md."""
