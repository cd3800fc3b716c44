# SPDX-License-Identifier: BSD-3-Clause
"""Target of the example network: the mean curvature of a surface of area 1, smoothed over a scale.

One step of implicit heat flow moves the points x of the surface to x' = (M + t L)^-1 M x, with L the cotangent
stiffness and M the lumped mass; (x - x') . n / (2 t), with n the normal, is the mean curvature averaged over
distances of about sqrt(t). It is positive on bumps and negative in hollows, and is here multiplied by sqrt(t), which
leaves a number without unit. Unlike the curvature of the triangles, it depends little on the triangulation.

    python3 smoothed_curvature.py surface.off training.safetensors [--vertices 2500]

writes points, triangles and values of a surface, decimated where it has more vertices than wanted, for
TrainRegression.
"""

import argparse
import os
import sys

import numpy as np

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), os.pardir, "Python"))

TIME = 1e-3  # of the heat flow, on a surface of area 1: smooths over a distance of about 0.03


def normalized(points, triangles):
    """Points moved to the area-weighted centroid and scaled to area 1."""
    corners = points[triangles]
    areas = 0.5 * np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    center = (corners.mean(axis=1) * areas[:, None]).sum(axis=0) / areas.sum()
    return (points - center) / np.sqrt(areas.sum())


def smoothed_curvature(points, triangles, time=TIME):
    """[V] the value at each point of a surface of any size."""
    points = normalized(np.asarray(points, dtype=np.float64), triangles)
    corners = points[triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    double_area = np.linalg.norm(normals, axis=1)
    count = len(points)

    def sum_at(corner, values):
        return np.bincount(triangles[:, corner], values, count)

    mass = sum(sum_at(k, double_area / 6.0) for k in range(3))
    vertex_normals = np.stack([sum(sum_at(k, normals[:, axis]) for k in range(3)) for axis in range(3)], axis=1)
    vertex_normals /= np.linalg.norm(vertex_normals, axis=1)[:, None]
    cotangents = []
    for k in range(3):
        first, second = corners[:, (k + 1) % 3] - corners[:, k], corners[:, (k + 2) % 3] - corners[:, k]
        cotangents.append(np.einsum("fx,fx->f", first, second) / double_area)

    def screened(x):
        """(M + t L) x"""
        result = mass * x
        for k, cotangent in enumerate(cotangents):
            i, j = (k + 1) % 3, (k + 2) % 3
            flow = 0.5 * time * cotangent * (x[triangles[:, i]] - x[triangles[:, j]])
            result += sum_at(i, flow) - sum_at(j, flow)
        return result

    smooth = np.stack([_solved(screened, mass * points[:, axis], points[:, axis], mass) for axis in range(3)], axis=1)
    return np.einsum("vx,vx->v", points - smooth, vertex_normals) / (2.0 * np.sqrt(time))


def _solved(apply, right, start, mass):
    """Conjugate gradients with the mass as preconditioner."""
    x, residual = start.copy(), right - apply(start)
    direction = residual / mass
    product = residual @ direction
    limit = 1e-9 * np.linalg.norm(right)
    for _ in range(5000):
        if np.linalg.norm(residual) <= limit:
            return x
        image = apply(direction)
        step = product / (direction @ image)
        x += step * direction
        residual -= step * image
        preconditioned = residual / mass
        product, last = residual @ preconditioned, product
        direction = preconditioned + product / last * direction
    raise RuntimeError("the conjugate gradients did not converge: the surface has bad triangles")


def main():
    import gallery_meshes as meshes
    import surfacesynthesis
    from surfacesynthesis.safetensors import write_safetensors

    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("surface")
    parser.add_argument("output")
    parser.add_argument("--vertices", type=int, default=2500, help="decimate to about so many (default: 2500)")
    arguments = parser.parse_args()
    fine = surfacesynthesis.read_mesh(arguments.surface)
    mesh = meshes.decimated(fine, arguments.vertices) if fine.GetNumberOfPoints() > arguments.vertices else fine
    points, triangles = meshes.arrays_of(mesh)
    values = smoothed_curvature(points, triangles)
    tensors = {"points": normalized(points, triangles), "triangles": triangles, "values": values[:, None]}
    write_safetensors(arguments.output, tensors, {"surface": os.path.basename(arguments.surface)})
    print(f"{len(points)} points, {len(triangles)} triangles, deviation of the values {values.std():.3f}")


if __name__ == "__main__":
    main()
