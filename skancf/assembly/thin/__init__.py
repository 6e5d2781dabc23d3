"""Assembly of theory `kirchhoff`."""
