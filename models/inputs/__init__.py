"""What users write and how they are answered: quantities with units, tables, errors."""
