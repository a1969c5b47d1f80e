"""The paper's claims, judged from marches and sweeps of its cases."""
