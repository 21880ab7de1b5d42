"""The random numbers of walks: small, portable, written down step by step in docs/files.md.

32-bit integers only, so that a page's script (``Math.imul``, ``>>> 0``) or a game engine draws the same ones.
"""

MASK = 0xFFFFFFFF


class RandomGenerator:
    """Chris Doty-Humphrey's sfc32 (PractRand), its state filled by splitmix32.

    Parameters
    ----------
    seed : 0 to 2^32 - 1

    Raises
    ------
    ValueError
        For another seed.
    """

    def __init__(self, seed: int) -> None:
        if not 0 <= seed <= MASK:
            raise ValueError(f"seed: expected a whole number from 0 to {MASK}, got {seed}")
        state, filled = seed, []
        for _ in range(3):
            state = (state + 0x9E3779B9) & MASK
            mixed = ((state ^ (state >> 16)) * 0x21F0AAAD) & MASK
            mixed = ((mixed ^ (mixed >> 15)) * 0x735A2D97) & MASK
            filled.append(mixed ^ (mixed >> 15))
        self._a, self._b, self._c = filled
        self._counter = 1
        for _ in range(12):
            self.draw()

    def draw(self) -> int:
        """The next number, 0 to 2^32 - 1."""
        drawn = (self._a + self._b + self._counter) & MASK
        self._counter = (self._counter + 1) & MASK
        self._a = self._b ^ (self._b >> 9)
        self._b = (self._c + (self._c << 3)) & MASK
        self._c = (((self._c << 21) | (self._c >> 11)) + drawn) & MASK
        return drawn
