"""Runs: from a case to a folder with result, summary, figures and series."""
