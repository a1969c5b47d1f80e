"""Style, legends, units and files of every figure."""
