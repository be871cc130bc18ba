"""What a level's table of shaders says of surfaces and of what brushes hold.

The values are those of ``surfaceflags.h`` in the game's published source, which level compilers
write for the ``surfaceparm`` words of shader scripts. Those that nothing here asks for are left
out.
"""

from enum import IntFlag


class Surface(IntFlag):
    """Surface flags; their names in lower case are the ``surfaceparm`` words."""

    SKY = 0x4
    NOIMPACT = 0x10
    NOMARKS = 0x20
    NODRAW = 0x80
    HINT = 0x100
    SKIP = 0x200
    NOLIGHTMAP = 0x400
    METALSTEPS = 0x1000
    NONSOLID = 0x4000
    ALPHASHADOW = 0x10000
    NODLIGHT = 0x20000


class Contents(IntFlag):
    """Content flags; 0 is air."""

    SOLID = 0x1
    LAVA = 0x8
    SLIME = 0x10
    WATER = 0x20
    PLAYERCLIP = 0x10000
    BODY = 0x2000000
    TRANSLUCENT = 0x20000000
