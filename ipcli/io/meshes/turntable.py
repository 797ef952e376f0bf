"""A page of its own in which a surface or a cloud can be turned, three.js within: nothing is fetched.

trimesh's viewer, with a title, a legend, and a first view that means something.
"""

from __future__ import annotations

from collections.abc import Mapping
from html import escape
from typing import Any

import numpy as np

VIEWER_TITLE = "<title>trimesh: threejs viewer</title>"
CONTAINER = '<div id="container"></div>'
CHANGES = (  # of the viewer's script: it turns about the pivot; light that adds up to 1 shows colours as they are given
    ("centerControls(scene,camera,controls);render();", "controls.target.set(0,0,0);render();"),
    ("new THREE.DirectionalLight(0xffffff,1.75)", "new THREE.DirectionalLight(0xffffff,0.55)"),
    (
        "scene.add(gltf.scene);",  # no metal, and seen from behind too; points of one pixel are hardly seen
        "scene.add(new THREE.AmbientLight(0xffffff,0.45));scene.add(gltf.scene);"
        "gltf.scene.traverse(o=>{if(o.isMesh){o.material.metalness=0;o.material.side=2;}"
        "if(o.isPoints){o.material.size=2;}});",
    ),
)
HINT = "Drag to turn, wheel to come nearer, right button to move."
UPRIGHT = np.diag([1.0, -1.0, -1.0])  # from a camera's axes, y down and z forward, to those of viewers: y up
STYLE = (
    "position:fixed;left:12px;top:10px;max-width:46em;font:14px/1.5 system-ui,sans-serif;color:#222;"
    "background:#ffffffd0;padding:6px 10px;border-radius:6px;pointer-events:none"
)
SWATCH = "display:inline-block;width:.8em;height:.8em;border-radius:50%;margin:0 .35em 0 .9em;background:rgb({},{},{})"
FIELD = 45.0  # degrees of the vertical field of view
Colour = tuple[int, int, int]


def turning_page(
    scene: Any,
    title: str,
    about: str,
    legend: Mapping[str, Colour] | None = None,
    *,
    from_camera: np.ndarray | None = None,
    field: float | None = None,
    pivot: np.ndarray | None = None,
) -> str:
    """The HTML of a trimesh scene, y up, with a sentence about it and what its colours mean.

    First seen from `from_camera` (4, 4), whose axes are x right, y up, z backwards, with the vertical `field` of view
    in degrees, turned to `pivot` (3,), about which the scene turns; if not given from the front, about the middle.
    """
    from trimesh.scene.cameras import Camera
    from trimesh.viewer import scene_to_html

    field = field or FIELD
    scene.camera = Camera(name="camera", fov=(1.3 * field, field))  # unnamed, it would get a random name
    if from_camera is None:
        from_camera = looking_from(np.asarray(scene.bounds), np.array([0.0, 0.0, 1.0]))
    middle = np.mean(scene.bounds, axis=0) if pivot is None else pivot
    scene.apply_translation(-middle)  # the viewer's light shines from the camera to the origin
    moved = np.array(from_camera, np.float64)
    moved[:3, 3] -= middle
    scene.camera_transform = moved
    swatches = "".join(
        f'<i style="{SWATCH.format(*colour)}"></i>{escape(name)}' for name, colour in (legend or {}).items()
    )
    words = f"<b>{escape(title)}</b><br>{escape(about)}{swatches}<br>{HINT}"
    html = scene_to_html(scene)
    for theirs, ours in CHANGES:
        html = html.replace(theirs, ours, 1)
    html = html.replace(VIEWER_TITLE, f"<title>{escape(title)}</title>", 1)
    return html.replace(CONTAINER, f'{CONTAINER}<div style="{STYLE}">{words}</div>', 1)


def cloud_scene(points: np.ndarray, colours: np.ndarray) -> Any:
    """The scene of points (n, 3), y up, in their colours (n, 3) uint8."""
    import trimesh

    return trimesh.Scene([trimesh.PointCloud(points, colours)])


def surface_scene(vertices: np.ndarray, faces: np.ndarray, colours: np.ndarray) -> Any:
    """The scene of a mesh (n, 3), (m, 3), y up, with a colour (n, 3) uint8 a vertex."""
    import trimesh

    return trimesh.Scene([trimesh.Trimesh(vertices, faces, vertex_colors=colours, process=False)])


def looking_from(vertices: np.ndarray, direction: np.ndarray, field: float = FIELD) -> np.ndarray:
    """The pose (4, 4) of a viewer's camera that sees all of `vertices` (n, 3), y up, from a direction (3,)."""
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    back = direction / np.linalg.norm(direction)
    right = np.cross((0.0, 1.0, 0.0), back)
    right /= np.linalg.norm(right)
    pose = np.eye(4)
    pose[:3, :3] = np.stack([right, np.cross(back, right), back], axis=1)
    reach = 0.5 * np.linalg.norm(high - low) / np.sin(np.radians(field / 2))
    pose[:3, 3] = (low + high) / 2 + reach * back
    return pose
