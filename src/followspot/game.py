"""Numbers of the game that several places go by, under the names of Quake III Arena's source.

Those that only a walker goes by are in `scene.walker` and `scene.slide`.
"""

FLOOR_BELOW_PLAYER = 24.0
"""Units from a player's origin down to the feet (``MINS_Z``)."""

EYE_HEIGHT = 26.0
"""Units from a player's origin up to the eye (``DEFAULT_VIEWHEIGHT``)."""

STEP_HEIGHT = 18.0
"""Units that a player climbs at once (``STEPSIZE``)."""

RUN_SPEED = 320.0
"""Units/s of a player who runs (``g_speed``)."""

GRAVITY = 800.0
"""Units/s^2 (``g_gravity``)."""
