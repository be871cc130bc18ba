"""OpenGL's numbers that moderngl has no names for, under the names of its specification."""

SRC_ALPHA_SATURATE = 0x0308
LINE_SMOOTH = 0x0B20
DEPTH_CLAMP = 0x864F
TEXTURE_CUBE_MAP_SEAMLESS = 0x884F
RGB9_E5 = 0x8C3D
SRGB8_ALPHA8 = 0x8C43
FRAMEBUFFER_SRGB = 0x8DB9
