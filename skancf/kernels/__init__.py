"""Compiled code that all theories share: gather and scatter, products in registers, which elements run at the same time."""
