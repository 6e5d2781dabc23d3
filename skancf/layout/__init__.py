"""Which unknowns there are: nodes of a mesh on a surface, what they are tied to, and which are held."""
