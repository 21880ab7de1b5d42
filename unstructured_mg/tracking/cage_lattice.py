"""A repeatable tet cage: cells of a body-centred cubic lattice, copied for every part that passes through them.

Parts that come close without touching (a hand at the hip, crossing legs) must not share cells. A cell is therefore
copied once for each connected piece of material in it, and copies are joined only where material runs from one to the
other (virtual nodes; Molino et al. 2004). Material is sampled by convex elements, whose part in a cell is connected by
itself: the surface's triangles, and the stretches of axis-parallel lines that lie inside the body. Nothing is inferred
from nearness, so open surfaces, holes and touching limbs are all the same case.
"""

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components

from unstructured_mg.geometry.tets import tet_volumes

# Lines and samples this many times denser than the lattice: every cell that lies inside the body then holds a sample,
# since the samples' covering radius (sqrt(3)/2 / 5 of the lattice constant) is below the cells' inradius (sqrt(2)/8).
_SAMPLES_PER_CONSTANT = 5
# Where the lattice starts relative to the bounding box, in lattice constants: irrational, so that quantised
# coordinates do not fall on cell faces or sampling lines.
_SHIFT = np.sqrt([2.0, 3.0, 5.0]) - 1.0
_LINE_SHIFT = np.sqrt([7.0, 11.0, 13.0]) / 10.0


def lattice_cage(vertices: np.ndarray, faces: np.ndarray, constant: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Cage vertices (c, 3), tets (q, 4) int32, positively oriented, and the tet (n,) int32 that holds each vertex.

    ``vertices`` (n, 3) float64 metres and welded, ``faces`` (m, 3) int32, ``constant`` the lattice constant in metres.
    """
    origin = vertices.min(0) - constant * (1 + _SHIFT / 2)
    positions, elements, nodes = _material(vertices, faces, constant / _SAMPLES_PER_CONSTANT, origin)
    codes, keys = _cells(positions, constant, origin)
    _, first, cell = np.unique(keys, return_index=True, return_inverse=True)
    cell = cell.reshape(-1)
    copy_of_node = _groups(nodes, elements * len(first) + cell[nodes], len(positions))
    copies = copy_of_node.max() + 1
    cell_of_copy = np.empty(copies, np.int64)
    cell_of_copy[copy_of_node] = cell
    corner_codes = codes[first][cell_of_copy]
    corner_keys = _pack(corner_codes.reshape(-1, 3)).reshape(-1, 4)
    _, lattice_vertex = np.unique(corner_keys, return_inverse=True)
    lattice_vertex = lattice_vertex.reshape(-1, 4)

    copy, element = copy_of_node[nodes], elements
    pairs = np.unique(np.stack([element, copy], axis=1), axis=0)
    corner = (4 * pairs[:, 1:] + np.arange(4)).ravel()
    shared = (pairs[:, :1] * (lattice_vertex.max() + 1) + lattice_vertex[pairs[:, 1]]).ravel()
    joined = _groups(corner, shared, 4 * copies).reshape(-1, 4)
    tets, tet_of_copy = _merge_adjacent_copies(joined, cell_of_copy)
    cage = np.zeros((tets.max() + 1, 3))
    cage[tets[tet_of_copy].ravel()] = origin + 0.5 * constant * corner_codes.reshape(-1, 3)
    negative = tet_volumes(cage, tets) < 0
    tets[negative] = tets[negative][:, [0, 1, 3, 2]]
    return cage, tets, tet_of_copy[copy_of_node[: len(vertices)]].astype(np.int32)


def _groups(items: np.ndarray, keys: np.ndarray, count: int) -> np.ndarray:
    """Component label (count,) of items 0..count-1, joined where they occur with the same key."""
    _, key = np.unique(keys, return_inverse=True)
    key = key.reshape(-1)
    graph = sp.coo_matrix((np.ones(len(items), np.int8), (items, count + key)), shape=[count + key.max() + 1] * 2)
    _, labels = connected_components(graph, directed=False)
    _, compact = np.unique(labels[:count], return_inverse=True)
    return compact.reshape(-1)


def _merge_adjacent_copies(joined: np.ndarray, cell: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Make copies of one cell that already share a face into one tet; returns tets and each copy's tet.

    Sampling may miss the sliver of material that joins two pieces inside a cell. Only copies that share a face before
    this pass count, so the pass cannot zip two limbs together along their gap.
    """
    corner = np.arange(joined.size).reshape(-1, 4)
    shared = cell[:, None] * 4 + np.arange(4)
    order = np.lexsort((joined.ravel(), shared.ravel()))
    same = (np.diff(shared.ravel()[order]) == 0) & (np.diff(joined.ravel()[order]) == 0)
    a, b = corner.ravel()[order][:-1][same] // 4, corner.ravel()[order][1:][same] // 4
    adjacency = sp.coo_matrix((np.ones(len(a)), (a, b)), shape=[len(joined)] * 2).tocsr()
    adjacency.data[:] = np.where(adjacency.data >= 3, 1.0, 0.0)
    adjacency.eliminate_zeros()
    _, tet = connected_components(adjacency, directed=False)
    vertex = _groups(joined.ravel(), (4 * tet[:, None] + np.arange(4)).ravel(), joined.max() + 1)
    tets = np.empty((tet.max() + 1, 4), np.int32)
    tets[tet] = vertex[joined]
    # Two cells copied alike in all four vertices would be one tet twice.
    _, first, again = np.unique(np.sort(tets, axis=1), axis=0, return_index=True, return_inverse=True)
    return tets[first], again.reshape(-1)[tet]


def _pack(codes: np.ndarray) -> np.ndarray:
    """One integer for each row of three small non-negative integers."""
    return (codes[:, 0].astype(np.int64) << 42) + (codes[:, 1].astype(np.int64) << 21) + codes[:, 2].astype(np.int64)


def _cells(points: np.ndarray, constant: float, origin: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The lattice tet of each point: its corners (p, 4, 3) in half constants, and a key (p,) that names the tet.

    Every tet joins the centres of two cubes that share a face to the two ends of one of that face's edges.
    """
    scaled = (points - origin) / constant
    cube = np.floor(scaled).astype(np.int64)
    local = scaled - cube - 0.5
    order = np.argsort(-np.abs(local), axis=1, kind="stable")
    sign = np.where(local < 0, -1, 1)
    across, along, free = (np.eye(3, dtype=np.int64)[order[:, i]] for i in range(3))
    centre = 2 * cube + 1
    other = centre + 2 * sign * across
    edge = centre + sign * across + sign * along
    codes = np.stack([np.minimum(centre, other), np.maximum(centre, other), edge - free, edge + free], axis=1)
    return codes, _pack(codes[:, 0] + codes[:, 1]) * 64 + (
        (codes[:, 2] + codes[:, 3] - codes[:, 0] - codes[:, 1]) // 2 + 1
    ) @ [1, 3, 9]


def _material(
    vertices: np.ndarray, faces: np.ndarray, step: float, origin: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Sample positions (p, 3), mesh vertices first, and the pairs (element, node): which element holds which."""
    start = len(vertices)
    positions, elements, nodes = [vertices], [np.repeat(np.arange(len(faces)), 3)], [faces.ravel().astype(np.int64)]

    # Points on long edges, shared by the edge's triangles.
    edges = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1)
    owner = np.tile(np.arange(len(faces)), 3)
    unique, edge_of = np.unique(edges, axis=0, return_inverse=True)
    edge_of = edge_of.reshape(-1)
    length = np.linalg.norm(vertices[unique[:, 1]] - vertices[unique[:, 0]], axis=1)
    inside = np.ceil(length / step).astype(np.int64) - 1
    inside[inside < 0] = 0
    which, rank = _ragged(inside)
    fraction = ((rank + 1) / (inside[which] + 1))[:, None]
    positions.append((1 - fraction) * vertices[unique[which, 0]] + fraction * vertices[unique[which, 1]])
    first_point = start + np.concatenate([[0], np.cumsum(inside)[:-1]])
    side, rank = _ragged(inside[edge_of])
    elements.append(owner[side])
    nodes.append(first_point[edge_of[side]] + rank)
    start += len(which)

    # Points inside large triangles.
    divisions = np.ceil(length[edge_of].reshape(3, -1).max(0) / step).astype(np.int64)
    divisions[divisions < 3] = 0
    face, rank = _ragged(divisions**2)
    i, j = rank // np.maximum(divisions[face], 1), rank % np.maximum(divisions[face], 1)
    kept = (i > 0) & (j > 0) & (i + j < divisions[face])
    face, i, j = face[kept], i[kept] / divisions[face[kept]], j[kept] / divisions[face[kept]]
    corners = vertices[faces[face]]
    positions.append(np.einsum("pk,pkx->px", np.stack([1 - i - j, i, j], axis=1), corners))
    elements.append(face)
    nodes.append(start + np.arange(len(face)))
    start += len(face)

    # Stretches of axis-parallel lines inside the body; lines of the three directions meet in the points of one grid.
    base, element_start = origin + step * _LINE_SHIFT, len(faces)
    grid_keys, grid_elements = [], []
    for axis in range(3):
        enter, leave, lines, low, high = _stretches(vertices, faces, axis, step, base)
        count = len(lines)
        element = element_start + np.arange(count)
        element_start += count
        for end, crossed in ((low, enter), (high, leave)):
            points = np.empty((count, 3))
            points[:, axis] = end
            for other in range(2):
                points[:, (axis + 1 + other) % 3] = base[(axis + 1 + other) % 3] + step * lines[:, other]
            positions.append(points)
            elements += [element, crossed]
            nodes += [start + np.arange(count)] * 2
            start += count
        bottom = np.ceil((low - base[axis]) / step).astype(np.int64)
        top = np.floor((high - base[axis]) / step).astype(np.int64)
        which, rank = _ragged(np.maximum(top - bottom + 1, 0))
        key = np.empty((len(which), 3), np.int64)
        key[:, axis] = bottom[which] + rank
        for other in range(2):
            key[:, (axis + 1 + other) % 3] = lines[which, other]
        grid_keys.append(key)
        grid_elements.append(element[which])
    keys, elements_of_grid = np.concatenate(grid_keys), np.concatenate(grid_elements)
    if len(keys):
        _, first, node = np.unique(_pack(keys + 2), return_index=True, return_inverse=True)
        positions.append(base + step * keys[first])
        elements.append(elements_of_grid)
        nodes.append(start + node.reshape(-1))
    return np.concatenate(positions), np.concatenate(elements), np.concatenate(nodes)


def _ragged(counts: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """For rows of the given lengths: the row of every entry and its rank in the row."""
    row = np.repeat(np.arange(len(counts)), counts)
    return row, np.arange(len(row)) - np.repeat(np.cumsum(counts) - counts, counts)


def _stretches(
    vertices: np.ndarray, faces: np.ndarray, axis: int, step: float, base: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Where lines along ``axis`` run from an entered triangle to a left one with no crossing between.

    Returns the two triangles, the line (r, 2) in grid steps, and the stretch's two ends along the axis.
    """
    plane = [(axis + 1) % 3, (axis + 2) % 3]
    flat = (vertices[:, plane] - base[plane]) / step
    corners = flat[faces]
    low = np.ceil(corners.min(1)).astype(np.int64)
    count = np.maximum(np.floor(corners.max(1)).astype(np.int64) - low + 1, 0)
    face, rank = _ragged(count[:, 0] * count[:, 1])
    line = low[face] + np.stack([rank // np.maximum(count[face, 1], 1), rank % np.maximum(count[face, 1], 1)], axis=1)
    a, b, c = (corners[face, i] for i in range(3))
    point = line.astype(np.float64)

    def doubled(p: np.ndarray, q: np.ndarray, r: np.ndarray) -> np.ndarray:
        return (q[:, 0] - p[:, 0]) * (r[:, 1] - p[:, 1]) - (q[:, 1] - p[:, 1]) * (r[:, 0] - p[:, 0])

    area = doubled(a, b, c)
    weights = np.stack([doubled(point, b, c), doubled(a, point, c), doubled(a, b, point)], axis=1)
    hit = (np.abs(area) > 1e-12) & (weights * np.sign(area)[:, None] >= 0).all(1)
    face, line, area, weights = face[hit], line[hit], area[hit], weights[hit]
    height = np.einsum("pk,pk->p", weights / area[:, None], vertices[faces[face], axis])
    order = np.lexsort((area > 0, height, line[:, 1], line[:, 0]))
    face, line, area, height = face[order], line[order], area[order], height[order]
    # A positive projected area is a normal along the axis: the line leaves the body there.
    inside = (area[:-1] < 0) & (area[1:] > 0) & (line[:-1] == line[1:]).all(1)
    return face[:-1][inside], face[1:][inside], line[:-1][inside], height[:-1][inside], height[1:][inside]
