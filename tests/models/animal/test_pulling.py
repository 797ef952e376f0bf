import numpy as np

from ipcli.geometry.orthographic import of_view
from ipcli.geometry.part_masks import framed, render
from ipcli.measurements.part_images import PartImage
from ipcli.models.animal.limbs import four_legged
from ipcli.models.animal.pulling import pulled


def test_a_body_that_was_squeezed_is_drawn_back_to_its_outlines():
    vertices, faces, labels, _ = four_legged(spacing=0.06)
    images, cameras = [], []
    for view in ("left", "front"):
        camera, shape = framed(vertices, of_view(view), 200)
        seen, _ = render(vertices, faces, labels, camera, shape)
        images.append(PartImage(view, seen, view))
        cameras.append(camera)
    part = np.zeros(len(vertices), int)
    part[faces[:, 0]] = labels - 1
    squeezed = vertices * [0.97, 0.9, 0.97]
    back = pulled(squeezed, faces, part, images, cameras)
    before, after = (np.linalg.norm(v - vertices, axis=1).mean() for v in (squeezed, back))
    assert after < 0.6 * before
    np.testing.assert_allclose(np.ptp(back, axis=0), np.ptp(vertices, axis=0), atol=0.06)


def test_a_body_that_fits_stays():
    vertices, faces, labels, _ = four_legged(spacing=0.06)
    camera, shape = framed(vertices, of_view("left"), 200)
    seen, _ = render(vertices, faces, labels, camera, shape)
    part = np.zeros(len(vertices), int)
    part[faces[:, 0]] = labels - 1
    moved = pulled(vertices, faces, part, [PartImage("left", seen, "left")], [camera])
    assert np.linalg.norm(moved - vertices, axis=1).mean() < 0.012  # of 3: half a pixel and a voxel's facets
