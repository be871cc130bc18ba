"""The passes of a frame, from named inputs to named outputs.

Rule of the room: binds and draws; opens no file and creates no GL object inside a frame.
"""
