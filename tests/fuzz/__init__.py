"""Problems of every kind and scale, made by chance, and what must hold for all of them.

``case`` says what a case is, ``bodies``, ``conditions``, ``cases`` and ``wrong`` make them, ``transforms`` restate them,
``properties`` lists what must hold; ``moving`` makes motions; each room of oracles (``linear``, ``invariance``,
``nonlinear``, ``vibration``, ``motion``, ``bars``, ``theory``) is pure functions of a case, and ``broken`` shows that they
can fail. ``python -m fuzz`` runs them without an end, ``tests/test_fuzz.py`` a bounded part.
"""
