"""Results of superelements: summary, motion of nodes and points, figures, ParaView series."""
