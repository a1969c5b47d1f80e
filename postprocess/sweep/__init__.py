"""Analyses of a sweep: its dataset, digests of its points, maps and diagrams."""
