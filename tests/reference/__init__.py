"""Answers from elsewhere: series, Ritz, elliptic integrals, and a slow twin of the element. No use of the library."""
