"""Poses as plain numbers, as Drake's."""

import numpy as np
from pydrake.common.eigen_geometry import Quaternion
from pydrake.math import RigidTransform


def rigid(pose) -> RigidTransform:
    """A pose qw qx qy qz x y z as Drake's."""
    q = np.asarray(pose[:4])
    return RigidTransform(Quaternion(q / np.linalg.norm(q)), pose[4:])
