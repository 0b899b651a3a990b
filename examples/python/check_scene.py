# Tells which parts of a scene may collide: those whose bounding boxes overlap. Takes a
# file that trimesh can load, or makes a scene. Needs trimesh. docs/python.md shows
# this program.
#
# SPDX-FileCopyrightText: 2026 the multisap authors
# SPDX-License-Identifier: MIT

import sys

import numpy as np
import trimesh

import multisap


def shelf():
    scene = trimesh.Scene()
    scene.add_geometry(trimesh.creation.box((4, 1, 0.1)), node_name="board")
    for i, x in enumerate((-1.5, -0.6, 0, 1.5)):
        place = trimesh.transformations.translation_matrix((x, 0, 0.55))
        scene.add_geometry(trimesh.creation.cylinder(0.4, 1), node_name=f"can {i}", transform=place)
    return scene


def bounds(scene, name):
    """The bounds of a part in the scene: a min and a max."""
    place, geometry = scene.graph[name]
    corners = trimesh.bounds.corners(scene.geometry[geometry].bounds)
    points = trimesh.transform_points(corners, place)
    return points.min(axis=0), points.max(axis=0)


scene = trimesh.load_scene(sys.argv[1]) if len(sys.argv) > 1 else shelf()
names = sorted(scene.graph.nodes_geometry)
boxes = np.array([bounds(scene, name) for name in names])
for a, b in multisap.prune((boxes[:, 0], boxes[:, 1])):
    print(names[a], "and", names[b])
