"""The parameters of tracking."""

from dataclasses import dataclass


@dataclass(frozen=True)
class TrackingOptions:
    """JSON-ready parameters of the tracking room; ValueError where one is out of its range.

    Attributes
    ----------
    cage : "lattice" (the same bytes every time, also for open surfaces) or "tetwild" (pytetwild in a child process)
    cage_vertices : about how many vertices a cage gets
    tetwild_seconds : time limit of one pytetwild run
    debris_share : components below this share of a frame's area count for nothing (P section 5.1 counts components)
    hausdorff_m : two-sided distance above which a pair is refused, metres (P section 5.4: 0.1)
    stretch : a pair is refused where the surface at s and at t, which look alike, differ by more than this stretch or
        squeeze on a twentieth of the area: limbs taken for one another, and sliding, which distances do not see. Chosen
        on the held-out pairs of known correspondence in benchmarks/tracking.py: those that were tracked stay below
        1.40, those that went wrong are above 1.49
    rigidity : weight of the cage's ARAP energy in the last stage of a registration; the energies are means over area
        and volume, lengths in units of the body's size (see ``register``)
    detail : transfer the captured frame's detail by normal offsets (P section 5.5). Off: after this registration it
        moves the surface away from the captured one and from the true correspondence (see benchmarks/tracking.py)
    detail_normals : smoothing weight of normals at unit area (P A.3: 1e-3)
    detail_offsets : smoothing weight of offsets at unit area (P A.3: 1e-4)
    detail_levels : levels of the detail hierarchy (P A.3: 3)
    """

    cage: str = "lattice"
    cage_vertices: int = 1500
    tetwild_seconds: float = 60.0
    debris_share: float = 0.01
    hausdorff_m: float = 0.1
    stretch: float = 1.45
    rigidity: float = 3e-5
    detail: bool = False
    detail_normals: float = 1e-3
    detail_offsets: float = 1e-4
    detail_levels: int = 3

    def __post_init__(self) -> None:
        if self.cage not in ("lattice", "tetwild"):
            raise ValueError(f'cage: expected "lattice" or "tetwild", got {self.cage!r}')
        if self.cage_vertices < 50:
            raise ValueError(f"cage_vertices: expected 50 or more, got {self.cage_vertices}")
        for name in ("tetwild_seconds", "hausdorff_m", "rigidity", "detail_normals", "detail_offsets"):
            if not getattr(self, name) > 0:
                raise ValueError(f"{name}: expected a positive number, got {getattr(self, name)}")
        if not self.stretch > 1:
            raise ValueError(f"stretch: expected a factor above 1, got {self.stretch}")
        if not 0 <= self.debris_share < 1:
            raise ValueError(f"debris_share: expected a share in 0..1, got {self.debris_share}")
        if self.detail_levels < 1:
            raise ValueError(f"detail_levels: expected 1 or more, got {self.detail_levels}")
