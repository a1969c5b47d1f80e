"""What a sweep says: its dataset, what is kept of a point, maps and diagrams."""
