"""The compiled step of the march; arrays in, arrays out."""
