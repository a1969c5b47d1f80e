"""Command line, and the studies that its commands compute."""
