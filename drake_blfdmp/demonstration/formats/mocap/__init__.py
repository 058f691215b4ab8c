"""Motion capture: C3D, BVH, body-model fits."""
