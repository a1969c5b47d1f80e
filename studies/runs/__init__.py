"""One run: from a case to a folder with its result, summary, figures and series."""
