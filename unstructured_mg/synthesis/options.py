"""Options of the synthesis room."""

from dataclasses import dataclass, field

from unstructured_mg.synthesis.texture_options import TextureOptions

BLEND_NAMES = ("volumetric_arap", "surface_arap", "poisson", "linear", "latent")
WEIGHT_NAMES = ("cubic", "linear")
TEXTURE_NAMES = ("flow", "crossfade", "none")


@dataclass(frozen=True)
class SynthesisOptions:
    """How transitions are made and which are refused. All values are JSON-ready.

    Geometry
    --------
    blend : "volumetric_arap" (P 6.4, the default), "surface_arap", "poisson" (B section 5), "linear" or "latent"
        (R section 4.6, needs torch)
    weights : "cubic" (P 6.4: keeps the velocity at both ends) or "linear"
    plant_feet : whether feet that stand in both windows are locked (see ``feet.plant_feet``)

    Texture
    -------
    texture : "flow" (P 6.3), "crossfade" or "none"
    texturing : the texture's own options; their ``method`` is what ``texture`` says

    What is refused
    ---------------
    A jump is a ratio: the change at a seam over the capture's own largest change inside the two windows, so that 1 is
    what a viewer of the capture sees anyway. On pairs of two real captures (an actor who stands, one who walks) seams
    have 0.1 to 1.1 of surface, 0.03 to 0.1 of velocity and 0 to 0.3 of colour.

    surface_jump : largest ratio of the change of surface at a seam
    surface_jump_floor : metres; a smaller change of surface is never refused. A tracked surface lies 0.3 to 1 mm from
        the captured one
    velocity_jump : largest ratio of the change of velocity at a seam
    velocity_jump_floor : metres a frame; a smaller change of velocity is never refused
    colour_jump : largest ratio of the mean change of colour at a seam
    colour_jump_floor : sRGB grey levels; a smaller mean change of colour is never refused
    volume_drift : largest share by which a frame's volume leaves the line between its two frames' volumes; below 0.001
        on those pairs, and 0.08 where limbs shrink as in a linear blend
    inverted_tets : largest number of cage cells that are turned inside out in a frame and in neither of its ends
    self_intersections : largest share of faces that intersect in the middle frame beyond those of its ends
    foot_slide : metres; largest way that a planted sole slides in the whole transition. In the windows of those pairs
        soles that stand move by 1 to 4 cm themselves, tracking noise included, and by 1 to 4 cm in the transitions
    sharpness : least gradient energy of the middle frame's texture, over the mean of its ends'. The mean of two
        textures that have nothing to do with each other has 0.5: less is blur that was not there before
    """

    blend: str = "volumetric_arap"
    weights: str = "cubic"
    plant_feet: bool = True
    texture: str = "flow"
    texturing: TextureOptions = field(default_factory=TextureOptions)
    surface_jump: float = 1.5
    surface_jump_floor: float = 0.002
    velocity_jump: float = 1.5
    velocity_jump_floor: float = 0.001
    colour_jump: float = 1.5
    colour_jump_floor: float = 4.0
    volume_drift: float = 0.05
    inverted_tets: int = 0
    self_intersections: float = 0.02
    foot_slide: float = 0.06
    sharpness: float = 0.4

    def __post_init__(self) -> None:
        for name, choices in (("blend", BLEND_NAMES), ("weights", WEIGHT_NAMES), ("texture", TEXTURE_NAMES)):
            if getattr(self, name) not in choices:
                raise ValueError(f"{name}: expected one of {', '.join(choices)}, got {getattr(self, name)!r}")
        if not isinstance(self.plant_feet, bool):
            raise ValueError(f"plant_feet: expected True or False, got {self.plant_feet!r}")
        for name in (
            "surface_jump",
            "surface_jump_floor",
            "velocity_jump",
            "velocity_jump_floor",
            "colour_jump",
            "colour_jump_floor",
            "volume_drift",
            "inverted_tets",
            "self_intersections",
            "foot_slide",
            "sharpness",
        ):
            if not getattr(self, name) >= 0:
                raise ValueError(f"{name}: expected a number not below 0, got {getattr(self, name)!r}")
