"""Results as time series for ParaView."""
