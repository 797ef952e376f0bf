"""One file a format. Only stages and report import this folder; atomic.py is the only writer."""
