"""Claims of the paper, judged by modal analyses, marches and sweeps."""
