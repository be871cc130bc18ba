"""What the program brings along: a courtyard, its sky, a robot, and scene files.

``courtyard.pk3`` and ``robot.pk3`` are written by ``python -m followspot.builtin.build_courtyard``
and ``build_robot``; everything in them is made by the scripts in this folder. ``courtyard.toml``
lights the courtyard and ``robots.toml`` puts robots into it; ``castle.toml`` lights a level of
OpenArena's, which has to be installed.
"""
