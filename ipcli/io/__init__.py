"""Readers and writers, a folder a family of data. Only stages, report and api import this folder."""
