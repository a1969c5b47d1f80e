"""Claims of the paper, judged by marches and sweeps of its cases."""
