"""Evaluation of results: fields, figures, series for ParaView, pictures. Results are only read."""
