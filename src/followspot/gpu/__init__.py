"""GL resources: context, programs, buffers, textures, uniform blocks, targets.

Rule of the room: takes a context and scene data, returns handles; decides nothing about
how a frame is drawn.
"""
