"""The march of a contact problem in time, and its recording."""
