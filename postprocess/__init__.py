"""What a result says: fields, figures, series for ParaView, pictures. Results are only read."""
