"""A theory on a mesh: forces, stresses and tangents of all elements."""
