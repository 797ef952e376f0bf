import numpy as np

from ipcli.geometry import open3d


def test_open3d_loads_without_system_libraries_and_casts_rays():
    library = open3d.load()
    box = library.t.geometry.TriangleMesh.create_box(1.0, 1.0, 1.0)
    scene = library.t.geometry.RaycastingScene()
    scene.add_triangles(box)
    rays = np.array([[0.3, 0.4, -2.0, 0, 0, 1], [3.0, 0.4, -2.0, 0, 0, 1]], np.float32)
    distance = scene.cast_rays(library.core.Tensor(rays))["t_hit"].numpy()
    np.testing.assert_allclose(distance, [2.0, np.inf], rtol=1e-6)
