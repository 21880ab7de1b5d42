"""Which faces meet at which edge, on any triangle soup; vertices split until every one has a single fan of faces."""

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components


def match_halfedges(vertices: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The neighbour of every face across every edge.

    Two faces are neighbours where they run through a shared edge in opposite senses. Where more than two could be,
    the flattest pairs are matched first; a face is never matched with its own reverse (surfaces stored twice, front
    and back, stay two sheets).

    Parameters
    ----------
    vertices : (n, 3) float64
    faces : (m, 3) int32 of three different vertices each

    Returns
    -------
    neighbor : (m, 3) int32, the face across the edge opposite corner i, or -1
    entry : (m, 3) int32, that face's corner opposite the shared edge (0 where there is none)
    """
    m = len(faces)
    tail, head = faces[:, [1, 2, 0]].ravel().astype(np.int64), faces[:, [2, 0, 1]].ravel().astype(np.int64)
    key = np.minimum(tail, head) * len(vertices) + np.maximum(tail, head)
    order = np.argsort(key, kind="stable")
    ordered = key[order]
    first = np.flatnonzero(np.r_[True, ordered[1:] != ordered[:-1]])
    count = np.diff(np.r_[first, len(order)])
    mate = np.full(3 * m, -1, np.int64)
    apex = faces.ravel()
    simple = first[count == 2]
    a, b = order[simple], order[simple + 1]
    fits = (tail[a] == head[b]) & (apex[a] != apex[b])
    mate[a[fits]], mate[b[fits]] = b[fits], a[fits]
    for begin, size in zip(first[count > 2], count[count > 2], strict=True):
        group = order[begin : begin + size]
        forward, backward = group[tail[group] < head[group]], group[tail[group] > head[group]]
        pairs = []
        for a in forward:
            axis = vertices[head[a]] - vertices[tail[a]]
            axis = axis / max(float(np.linalg.norm(axis)), 1e-300)
            for b in backward:
                if apex[a] != apex[b]:
                    sides = [vertices[apex[h]] - vertices[tail[a]] for h in (a, b)]
                    sides = [side - axis * (side @ axis) for side in sides]
                    lengths = max(float(np.linalg.norm(sides[0]) * np.linalg.norm(sides[1])), 1e-300)
                    pairs.append((float(sides[0] @ sides[1]) / lengths, int(a), int(b)))
        for _, a, b in sorted(pairs):
            if mate[a] < 0 and mate[b] < 0:
                mate[a], mate[b] = b, a
    neighbor = np.where(mate >= 0, mate // 3, -1).astype(np.int32).reshape(m, 3)
    entry = np.where(mate >= 0, mate % 3, 0).astype(np.int32).reshape(m, 3)
    return neighbor, entry


def split_fans(faces: np.ndarray, neighbor: np.ndarray, entry: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Give every fan of matched faces a vertex of its own.

    Returns faces (m, 3) int32 over the new vertices and, for each new vertex, the old one (k,) int32. Vertices that no
    face uses are left out.
    """
    m = len(faces)
    face, corner = np.nonzero(neighbor >= 0)
    other, across = neighbor[face, corner].astype(np.int64), entry[face, corner]
    rows = np.concatenate([3 * face + (corner + 1) % 3, 3 * face + (corner + 2) % 3])
    columns = np.concatenate([3 * other + (across + 2) % 3, 3 * other + (across + 1) % 3])
    graph = sp.coo_matrix((np.ones(len(rows), np.int8), (rows, columns)), (3 * m, 3 * m))
    count, label = connected_components(graph, directed=False)
    origin = np.zeros(count, np.int32)
    origin[label] = faces.ravel()
    return label.reshape(m, 3).astype(np.int32), origin
