"""Cases, finite elements and reduction: what there is before anything moves."""
