"""One synthesized transition, as the graph sees it."""

from dataclasses import dataclass

from unstructured_mg.geometry.planar import PlanarRigid


@dataclass(frozen=True)
class Link:
    """A way from captured frame ``leaves`` through steps ``-k+1 .. k-1`` to captured frame ``arrives``.

    Attributes
    ----------
    source, target : frame indices s and t
    k : half window, at least 1
    alignment : the target's captured place to the source's; it joins the world transform where the transition ends
    cost : how much the transition is to be avoided, 0 or more (lower is better)
    ends : the captured frames that it leaves and arrives at; None where these are ``source - k`` and ``target + k``
    """

    source: int
    target: int
    k: int
    alignment: PlanarRigid
    cost: float
    ends: tuple[int, int] | None = None

    @property
    def leaves(self) -> int:
        """The captured frame that the transition starts from."""
        return self.source - self.k if self.ends is None else self.ends[0]

    @property
    def arrives(self) -> int:
        """The captured frame that the transition leads to."""
        return self.target + self.k if self.ends is None else self.ends[1]

    @property
    def steps(self) -> range:
        """The steps that are played; steps -k and k equal captured frames."""
        return range(-self.k + 1, self.k)
