"""What the program brings along: a courtyard, its sky and the scene file that lights it.

``courtyard.pk3`` is written by ``python -m followspot.builtin.build_courtyard``; everything in it
is made by the scripts in this folder.
"""
