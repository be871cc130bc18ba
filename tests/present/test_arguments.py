"""What is typed, as cameras of a scene."""

from dataclasses import replace

import pytest

from followspot.errors import UsageError
from followspot.present.arguments import parse_camera
from synthetic import camera, floor, make_scene


def test_names_of_the_scene_come_before_numbers() -> None:
    views = {"a b,c": camera((1, 2, 3)), "1,2,3,4,5": camera((7, 8, 9))}
    scene = replace(make_scene([floor()]), cameras=views)
    for name, view in views.items():
        assert parse_camera(name, None, scene) is view
    assert parse_camera("a b,c", 50, scene).fov == 50
    typed = parse_camera("1,2,3,4,6", None, scene)
    assert (typed.position.tolist(), typed.yaw, typed.pitch) == ([1, 2, 3], 4, 6)
    with pytest.raises(UsageError, match="expected x,y,z,yaw,pitch, found 'a,b'"):
        parse_camera("a,b", None, scene)
    with pytest.raises(UsageError, match="no camera is named 'a'"):
        parse_camera("a", None, scene)
