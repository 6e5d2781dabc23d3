"""Assembly of theory `full`."""
