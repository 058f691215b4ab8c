"""What a person sees of a run: figures from its log, and the live or recorded Meshcat scene.

    style           palette, sizes and the axes' common dress
    figures         write_figures: every figure of one run
    skill_figures   link lengths, hands' distance, paths
    robot_figures   joint angles, contact forces, the box, swivel angles
    meshcat_scene   start_meshcat, set_scene_camera, write_scene_html
    skeleton_drawer SkeletonGhost (draws), SkeletonDrawer (a LeafSystem that draws what its input ports say)

Nothing is imported here, so that figures need no Drake and the scene needs no matplotlib.
"""
