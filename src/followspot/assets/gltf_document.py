"""The JSON of a glTF 2.0 document as checked records; what nobody here reads is passed over.

Source: "glTF 2.0 Specification", version 2.0.1, The Khronos Group, chapter 5.
"""

from typing import Annotated, Any, TypeVar

import msgspec
from msgspec import Meta, Struct

from followspot.assets import complaints
from followspot.assets.mesh_record import MAX_VERTICES
from followspot.errors import AssetError

MAX_NODES = 1 << 16
"""Most nodes of a file."""

REPEAT, TRIANGLES = 10497, 4
"""What a sampler does at an image's border, and how corners make a primitive, unless told."""

Index = Annotated[int, Meta(ge=0, le=2**31)]
Size = Annotated[int, Meta(ge=0, le=2**40)]
Number3 = tuple[float, float, float]
Number4 = tuple[float, float, float, float]


class Table(Struct, rename="camel", frozen=True, kw_only=True):
    """A JSON object of the format."""


class Asset(Table, frozen=True, kw_only=True):
    """What the file says of itself."""

    version: str


class Buffer(Table, frozen=True, kw_only=True):
    """Bytes, in a file of their own, in a data URI, or in the GLB."""

    byte_length: Size
    uri: str | None = None


class View(Table, frozen=True, kw_only=True):
    """A run of a buffer's bytes."""

    buffer: Index
    byte_length: Size
    byte_offset: Size = 0
    byte_stride: Annotated[int, Meta(ge=4, le=252)] | None = None


class Accessor(Table, frozen=True, kw_only=True):
    """Numbers in a view."""

    component_type: int
    count: Annotated[int, Meta(ge=1, le=MAX_VERTICES)]
    type: str
    buffer_view: Index | None = None
    byte_offset: Size = 0
    normalized: bool = False
    sparse: dict[str, Any] | None = None


class Image(Table, frozen=True, kw_only=True):
    """A picture in a view or a file."""

    uri: str | None = None
    buffer_view: Index | None = None


class Sampler(Table, frozen=True, kw_only=True):
    """What is beyond an image's border."""

    wrap_s: int = REPEAT
    wrap_t: int = REPEAT


class Texture(Table, frozen=True, kw_only=True):
    """An image with its sampler."""

    source: Index | None = None
    sampler: Index | None = None


class Transform(Table, frozen=True, kw_only=True):
    """What ``KHR_texture_transform`` does to texture coordinates."""

    offset: tuple[float, float] = (0.0, 0.0)
    rotation: float = 0.0
    scale: tuple[float, float] = (1.0, 1.0)
    tex_coord: Index | None = None


class InfoExtensions(Struct, frozen=True, kw_only=True):
    """Extensions of a texture's use."""

    transform: Transform | None = msgspec.field(name="KHR_texture_transform", default=None)


class TextureInfo(Table, frozen=True, kw_only=True):
    """A texture's use in a material."""

    index: Index
    tex_coord: Index = 0
    extensions: InfoExtensions = InfoExtensions()


class Roughness(Table, frozen=True, kw_only=True):
    """Of a material's surface, its base colour."""

    base_color_factor: Number4 = (1.0, 1.0, 1.0, 1.0)
    base_color_texture: TextureInfo | None = None


class Material(Table, frozen=True, kw_only=True):
    """What a primitive wears."""

    pbr_metallic_roughness: Roughness = Roughness()
    alpha_mode: str = "OPAQUE"
    alpha_cutoff: Annotated[float, Meta(ge=0)] = 0.5
    double_sided: bool = False


class Primitive(Table, frozen=True, kw_only=True):
    """Points, lines or triangles."""

    attributes: dict[str, Index]
    indices: Index | None = None
    material: Index | None = None
    mode: int = TRIANGLES


class Mesh(Table, frozen=True, kw_only=True):
    """Primitives that are placed together."""

    primitives: tuple[Primitive, ...]


class Node(Table, frozen=True, kw_only=True):
    """A place in the tree of a scene."""

    children: tuple[Index, ...] = ()
    mesh: Index | None = None
    matrix: Annotated[tuple[float, ...], Meta(min_length=16, max_length=16)] | None = None
    translation: Number3 = (0.0, 0.0, 0.0)
    rotation: Number4 = (0.0, 0.0, 0.0, 1.0)
    scale: Number3 = (1.0, 1.0, 1.0)


class Scene(Table, frozen=True, kw_only=True):
    """Roots of trees."""

    nodes: tuple[Index, ...] = ()


class Head(Table, frozen=True, kw_only=True):
    """What decides whether a file can be read at all."""

    asset: Asset
    extensions_required: tuple[str, ...] = ()


class Document(Table, frozen=True, kw_only=True):
    """A whole file."""

    buffers: tuple[Buffer, ...] = ()
    buffer_views: tuple[View, ...] = ()
    accessors: tuple[Accessor, ...] = ()
    images: tuple[Image, ...] = ()
    samplers: tuple[Sampler, ...] = ()
    textures: tuple[Texture, ...] = ()
    materials: tuple[Material, ...] = ()
    meshes: tuple[Mesh, ...] = ()
    nodes: Annotated[tuple[Node, ...], Meta(max_length=MAX_NODES)] = ()
    scenes: tuple[Scene, ...] = ()
    scene: Index = 0


Kind = TypeVar("Kind")


def decode(text: bytes, kind: type[Kind], source: str) -> Kind:
    """A record of a document.

    Raises:
        AssetError: the text is no JSON, or something in it is not of the format.
    """
    try:
        return msgspec.json.decode(text.rstrip(b"\0 "), type=kind)
    except msgspec.ValidationError as error:
        said, place = complaints.taken_apart(error)
        expected, _, found = said.removeprefix("Expected ").partition(", got ")
        if (key := complaints.missing_key(said)) is not None:
            place = f"{place}.{key}".lstrip(".")
            expected, found = "a value, which glTF requires", "none"
        expected, found = expected.replace("`", ""), found.replace("`", "")
        found = found or _shown_at(text, place)
        raise AssetError(source, place=place, expected=expected, found=found) from None
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError) as error:
        raise AssetError(source, place="JSON", expected="JSON", found=str(error)) from None


def _shown_at(text: bytes, place: str) -> str:
    try:
        return complaints.shown_at(msgspec.json.decode(text.rstrip(b"\0 ")), place)
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError):
        return "another"
