"""Are error bars right? Scenes with known answers, and an assessment of the bars that ``adapt`` gives for them.

``scenes.json`` states the scenes and what is asked of them, ``references.json`` holds the right values, by
``references.py``. ``run.py`` asks ``adapt`` and writes what came out, ``assessment.py`` has the rule.
"""
