from collections import Counter, defaultdict

import numpy as np
import pytest
import pyvista

from unstructured_mg.geometry import decimate as module
from unstructured_mg.geometry.closest import ClosestPoints
from unstructured_mg.geometry.decimate import decimate


def grid(side, height=None):
    """A sheet of (side + 1)^2 vertices over the unit square."""
    y, x = np.mgrid[: side + 1, : side + 1].reshape(2, -1) / side
    i = np.arange(side * (side + 1)).reshape(side, side + 1)[:, :side].ravel()
    faces = np.concatenate([np.stack([i, i + 1, i + side + 2], 1), np.stack([i, i + side + 2, i + side + 1], 1)])
    return np.stack([x, y, np.zeros_like(x) if height is None else height(x, y)], 1), faces.astype(np.int32)


def charted(vertices, faces, charts):
    """Project each chart of faces to the plane, in a tile of its own: (uv, face_uv)."""
    uv, face_uv = [], np.empty_like(faces)
    for chart in range(charts.max() + 1):
        used, corners = np.unique(faces[charts == chart], return_inverse=True)
        face_uv[charts == chart] = corners.reshape(-1, 3) + sum(map(len, uv))
        uv.append(vertices[used, :2] * 0.2 + [0.25 * chart, 0.1])
    return np.concatenate(uv), face_uv


def sphere(level):
    mesh = pyvista.Icosphere(radius=1.0, nsub=level)
    return np.asarray(mesh.points, np.float64), np.asarray(mesh.regular_faces, np.int32)


def edge_counts(faces):
    return Counter(tuple(sorted(edge)) for a, b, c in faces.tolist() for edge in ((a, b), (b, c), (c, a)))


def brute_force(poses, faces, uv, face_uv, material):
    """The cheapest allowed collapse straight from its definition: (cost, from, to), over all directed edges."""
    n, corners = poses.shape[1], [list(zip(f, zip(w, [m] * 3, strict=True), strict=True)) for f, w, m in zip(
        faces.tolist(), face_uv.tolist(), material.tolist(), strict=True)]  # fmt: skip
    counts, wedge_edges = edge_counts(faces), Counter()
    for face in corners:
        for i in range(3):
            wedge_edges[frozenset((face[i], face[(i + 1) % 3]))] += 1
    planes, slides, area_of = defaultdict(list), defaultdict(list), np.zeros(n)
    a, b, c = (poses[0][faces[:, i]] for i in range(3))
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()
    a, b, c = (uv[face_uv[:, i]] for i in range(3))
    metres = module.SLIDING * np.sqrt(area / np.abs(np.cross(np.pad(b - a, ((0, 0), (0, 1))),
                                                             np.pad(c - a, ((0, 0), (0, 1))))[:, 2]).sum())  # fmt: skip
    for face in corners:
        for pose, points in enumerate(poses):
            p = points[[v for v, _ in face]]
            normal = np.cross(p[1] - p[0], p[2] - p[0])
            area = np.linalg.norm(normal) / 2
            normal /= 2 * area
            for i, (v, wedge) in enumerate(face):
                planes[pose, v].append((area, normal, -normal @ p[0]))
                area_of[v] += area / len(poses)
                end = face[(i + 1) % 3]
                count = counts[tuple(sorted((v, end[0])))]
                if count != 2 or wedge_edges[frozenset((face[i], end))] != 2:
                    side = np.cross(p[(i + 1) % 3] - p[i], normal)
                    weight = side @ side * (module.SEAM if count == 2 else module.BOUNDARY)
                    side /= np.linalg.norm(side)
                    for at in (v, end[0]):
                        planes[pose, at].append((weight, side, -side @ p[i]))
                if pose == 0:
                    values = uv[[w[0] for _, w in face]]
                    gradient = np.linalg.pinv(np.stack([p[1] - p[0], p[2] - p[0]])) @ (values[1:] - values[0])
                    slides[v, wedge].append((area * metres**2, gradient, values[0] - p[0] @ gradient))
    found = []
    neighbours = defaultdict(set)
    for x, y in counts:
        neighbours[x].add(y)
        neighbours[y].add(x)
    for u in range(n):
        star = [f for f in corners if u in [v for v, _ in f]]
        open_edges = sum(counts[tuple(sorted((u, v)))] == 1 for v in neighbours[u])
        for v in neighbours[u]:
            shared = [dict(f) for f in star if v in dict(f)]
            count = len(shared)
            kept = [f for f in star if v not in dict(f)]
            carried = {(f[u], f[v]) for f in shared}
            others = sum(v in dict(f) for f in corners)
            if count > 2 or open_edges not in (0, 2) or (open_edges and count != 1) or not kept:
                continue
            if len({a for a, _ in carried}) != len(carried) or len({b for _, b in carried}) != len(carried):
                continue
            if {dict(f)[u] for f in star} != {a for a, _ in carried} or len(neighbours[u] & neighbours[v]) != count:
                continue
            if len(star) + others - 2 * count > 16:
                continue
            moves = dict(carried)
            if any(turns(poses, uv, f, u, v, moves) for f in kept):
                continue
            cost = 0.0
            for pose, points in enumerate(poses):
                for at in (u, v):
                    cost += sum(w * (m @ points[v] + d) ** 2 for w, m, d in planes[pose, at])
                cost += 1e-3 * area_of[u] * ((points[v] - points[u]) ** 2).sum()
            cost /= len(poses)
            for a, b in carried:
                for key in ((u, a), (v, b)):
                    cost += sum(w * ((poses[0][v] @ g + d - uv[b[0]]) ** 2).sum() for w, g, d in slides[key])
            found.append((cost, u, v))
    return min(found, default=None)


def turns(poses, uv, face, u, v, moves):
    i = [at for at, _ in face].index(u)
    (_, wedge), (b, wb), (a, wa) = face[i], face[(i + 1) % 3], face[(i + 2) % 3]
    for points in poses:
        old, new = (np.cross(points[a] - points[b], points[x] - points[b]) for x in (u, v))
        along = old @ new
        if along <= 0 or along**2 < 0.04 * (old @ old) * (new @ new):
            return True
    p, q, old, new = uv[wb[0]], uv[wa[0]], uv[wedge[0]], uv[moves[wedge][0]]
    was, now = ((q - p)[0] * (x - p)[1] - (q - p)[1] * (x - p)[0] for x in (old, new))
    return was != 0 and was * now <= 0


@pytest.mark.parametrize("seed", range(12))
def test_the_first_to_go_is_the_cheapest_of_all_that_may(seed):
    random = np.random.default_rng(seed)
    vertices, faces = grid(6)
    vertices = vertices + 0.04 * random.normal(size=vertices.shape)
    faces = faces[random.random(len(faces)) > 0.04 * (seed % 3)]
    charts = (vertices[faces].mean(axis=1)[:, 0] > 0.45).astype(int) + (seed % 2)
    charts[random.random(len(charts)) < 0.05] = 3
    _, charts = np.unique(charts, return_inverse=True)
    uv, face_uv = charted(vertices, faces, charts)
    material = (vertices[faces].mean(axis=1)[:, 1] > 0.6).astype(np.int32) * (seed % 4 == 0)
    poses = vertices[None] if seed % 3 else np.stack([vertices, vertices + 0.03 * random.normal(size=vertices.shape)])
    _, u, _ = brute_force(poses, faces, uv, face_uv, material)
    done = decimate(poses, faces, len(faces) - 1, uv, face_uv, material)
    assert set(range(len(vertices))) - set(done.vertex_index) - (set(range(len(vertices))) - set(faces.ravel())) == {u}


def test_where_nothing_bends_nothing_changes():
    vertices, faces = grid(12)
    charts = (vertices[faces].mean(axis=1)[:, 0] > 0.5).astype(int)
    uv, face_uv = charted(vertices, faces, charts)
    done = decimate(vertices, faces, 4, uv, face_uv)
    left = vertices[done.vertex_index]
    # The corners and the seam's ends, and texture where it was: two charts of two triangles each.
    assert len(done.faces) == 4
    assert sorted(map(tuple, left[:, :2])) == [(0, 0), (0, 1), (0.5, 0), (0.5, 1), (1, 0), (1, 1)]
    tile = 0.25 * charts[done.face_index][:, None, None] * [1, 0] + [0, 0.1]
    np.testing.assert_allclose(uv[done.uv_index][done.face_uv], left[done.faces][..., :2] * 0.2 + tile, atol=1e-12)


@pytest.mark.parametrize("goal", [600, 200, 40])
def test_a_closed_surface_stays_closed_and_every_uv_stays_its_vertexs(goal):
    vertices, faces = sphere(4)
    middle = vertices[faces].mean(axis=1)
    charts = (middle[:, 0] > 0.1).astype(int) + 2 * (middle[:, 1] > 0.2)
    uv, face_uv = charted(vertices, faces, charts)
    done = decimate(vertices, faces, goal, uv, face_uv, charts)
    assert goal - 1 <= len(done.faces) <= goal
    assert set(edge_counts(done.faces).values()) == {2}
    assert len(done.vertex_index) - len(done.faces) // 2 == 2
    before = defaultdict(set)
    for v, w, chart in zip(faces.ravel(), face_uv.ravel(), np.repeat(charts, 3), strict=True):
        before[v].add((w, chart))
    corners = zip(done.vertex_index[done.faces].ravel(), done.uv_index[done.face_uv].ravel(),
                  np.repeat(charts[done.face_index], 3), strict=True)  # fmt: skip
    assert all((w, chart) in before[v] for v, w, chart in corners)
    # No triangle turns inside out, in space or in the atlas.
    a, b, c = (vertices[done.vertex_index][done.faces[:, i]] for i in range(3))
    assert (np.einsum("ij,ij->i", np.cross(b - a, c - a), a + b + c) > 0).all()


def test_it_misses_the_surface_by_little_more_than_vtk_does():
    vertices, faces = grid(40, lambda x, y: 0.1 * np.sin(7 * x) * np.cos(5 * y))
    ours = decimate(vertices, faces, 320)
    theirs = pyvista.PolyData.from_regular_faces(vertices, faces).decimate(0.9)
    missed = [np.sqrt(ClosestPoints(v, f).query(vertices)[0].mean()) for v, f in (
        (vertices[ours.vertex_index], ours.faces),
        (np.asarray(theirs.points, np.float64), np.asarray(theirs.regular_faces, np.int32)))]  # fmt: skip
    assert len(ours.faces) <= 320 <= theirs.n_cells + 2
    assert missed[0] < 2.0 * missed[1]  # vertices are chosen among those there are, theirs are placed freely


def test_all_poses_count():
    """A crease that only the second pose shows is kept."""
    vertices, faces = grid(20)
    bent = vertices + np.stack([0 * vertices[:, 0], 0 * vertices[:, 0], np.abs(vertices[:, 0] - 0.5)], 1)
    done = decimate(np.stack([vertices, bent]), faces, 8)
    missed = ClosestPoints(bent[done.vertex_index], done.faces).query(bent)[0]
    assert len(done.faces) <= 8 and missed.max() < 1e-12
    alone = decimate(vertices, faces, 8)
    assert ClosestPoints(bent[alone.vertex_index], alone.faces).query(bent)[0].max() > 1e-3


def test_what_cannot_be_spared_stays():
    """Corners of charts: an atlas of one triangle a chart cannot shrink at all."""
    vertices, faces = sphere(2)
    uv, face_uv = np.random.default_rng(0).random((3 * len(faces), 2)), np.arange(3 * len(faces)).reshape(-1, 3)
    done = decimate(vertices, faces, 10, uv, face_uv.astype(np.int32))
    np.testing.assert_array_equal(done.faces, faces)
    np.testing.assert_array_equal(done.face_uv, face_uv)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"vertices": np.zeros((3, 2))}, "vertices: expected finite"),
        ({"vertices": np.full((81, 3), np.nan)}, "vertices: expected finite"),
        ({"faces": np.full((4, 3), 81, np.int32)}, r"faces: expected indices in 0..80, got 81..81"),
        ({"faces": np.zeros((0, 3), np.int32)}, "faces: expected"),
        ({"goal": 0}, "goal: expected 1 face or more, got 0"),
        ({"uv": np.zeros((2, 2)), "face_uv": np.full((128, 3), 2)}, "face_uv: expected indices in 0..1"),
        ({"face_material": np.zeros(5, int)}, r"face_material: expected \(128,\)"),
    ],
)
def test_what_does_not_fit_together_is_named(change, said):
    vertices, faces = grid(8)
    with pytest.raises(ValueError, match=said):
        decimate(**{"vertices": vertices, "faces": faces, "goal": 5, **change})
