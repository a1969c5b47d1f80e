"""Export of results as time series for ParaView."""
