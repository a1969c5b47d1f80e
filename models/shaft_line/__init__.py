"""A flexible shaft with disks and bearings: its matrices, whirl, critical speeds and responses."""
