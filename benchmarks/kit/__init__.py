"""What benchmarks share: `measure` runs and times, `publish` writes tables, `arguments` are the options in common."""
