"""The search for the parameters that the paper leaves out."""
