"""Common parts of all figures: style, axes, titles, legends, files, and the registry of figures."""
