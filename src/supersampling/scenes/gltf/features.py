"""Features of glTF 2.0 and its extensions that are drawn otherwise than the file says, in the words of the warnings.

docs/gltf.md has a row for each, and for each feature that is drawn as the file says.
"""

from enum import StrEnum


class Deviation(StrEnum):
    """Warnings about features of the specification itself and of extensions that are read."""

    TOPOLOGY = "points and lines are left out"
    POSITIONS = "primitives without positions are left out"
    FLAT_MESHES = "meshes of no size are left out"
    NOT_FINITE = "attribute values that are not finite are read as zero"
    NO_COORDINATES = "textures whose texture coordinates are missing show a single texel"
    COORDINATES = "textures with other coordinates than their material's first are left out"
    SAMPLERS = "textures with another sampler than their material's first use the first's filters and wrapping"
    LARGE_IMAGES = "images of more than 4096 pixels per side are halved until they fit"
    IMAGES = "textures without a PNG or JPEG image are left out"
    BLENDING = "blending is drawn as a test at half opacity"
    OCCLUSION = "occlusion maps are left out"
    EMISSION = "emissions brighter than 60000 are drawn as 60000"
    SKINS = "skinned meshes stay in their rest pose"
    WEIGHTS = "animations of morph targets are left out: they keep the weights of the mesh or node"
    CHANNELS = "animations of anything other than nodes are left out"
    TWICE = "animations of properties that an earlier animation moves are left out"
    SCENES = "of several scenes without a default only the first is drawn"
    ORTHOGRAPHIC = "cameras that are not perspective are left out"
    FLAT_CAMERAS = "cameras of no size are left out"
    ASPECT = "the aspect ratio of cameras is that of the rendered frame"
    PLANES = "the near and far planes of cameras do not cut the geometry"
    MOVING_LIGHTS = "moving lights stand where they are at time 0"
    SUNS = "of several directional lights only the brightest is kept"


DRAWN_EXTENSIONS = frozenset(
    {
        "KHR_lights_punctual",
        "KHR_materials_emissive_strength",
        "KHR_materials_unlit",
        "KHR_mesh_quantization",
        "KHR_texture_transform",
    }
)

NEUTRAL_EXTENSIONS = frozenset({"KHR_materials_variants", "KHR_xmp", "KHR_xmp_json_ld"})
"""Extensions that do not change the default picture."""

SUPPORTED = DRAWN_EXTENSIONS | NEUTRAL_EXTENSIONS
"""Extensions that a file may require."""

_COMPRESSED = "the uncompressed mesh beside it is drawn"
_ENCODED = "the PNG or JPEG image beside it is drawn, or none"
IGNORED_EXTENSIONS = {
    "KHR_animation_pointer": "only translations, rotations and scales of nodes move",
    "KHR_draco_mesh_compression": _COMPRESSED,
    "KHR_materials_anisotropy": "highlights are as wide as they are long",
    "KHR_materials_clearcoat": "coats are left out",
    "KHR_materials_diffuse_transmission": "light does not pass through surfaces",
    "KHR_materials_dispersion": "light is not split into colours",
    "KHR_materials_ior": "the index of refraction is 1.5",
    "KHR_materials_iridescence": "thin films are left out",
    "KHR_materials_pbrSpecularGlossiness": "materials keep their metallic-roughness values",
    "KHR_materials_sheen": "sheen is left out",
    "KHR_materials_specular": "dielectrics reflect 4% at normal incidence",
    "KHR_materials_transmission": "surfaces are not transparent",
    "KHR_materials_volume": "volumes neither refract nor absorb light",
    "KHR_meshopt_compression": _COMPRESSED,
    "KHR_node_visibility": "hidden nodes are drawn",
    "KHR_texture_basisu": _ENCODED,
    "EXT_lights_ies": "lights shine evenly",
    "EXT_lights_image_based": "the sky is the default one",
    "EXT_mesh_gpu_instancing": "one instance per node is drawn",
    "EXT_meshopt_compression": _COMPRESSED,
    "EXT_texture_avif": _ENCODED,
    "EXT_texture_webp": _ENCODED,
    "MSFT_lod": "the most detailed level is drawn",
    "MSFT_texture_dds": _ENCODED,
}
"""Effect of ignoring an extension; others are ignored as well, with a warning that names them."""


def ignored_extension(name: str) -> str:
    """Return the warning for an extension that is not supported."""
    effect = IGNORED_EXTENSIONS.get(name)
    return f"the extension {name} is ignored" + (f" ({effect})" if effect else "")
