"""What a person sees of a run or a study: figures, stills, and the live or recorded Meshcat scene.

    style           palette, sizes and the axes' common dress
    law_style       one look for every law
    figures         write_figures: every figure of one run
    skill_figures   link lengths, hands' distance, paths
    robot_figures   joint angles, contact forces, the box, swivel angles
    study_figures   a package: the drawings of the studies
    rendering       triangles, a camera and pictures of them, without a GPU
    stills          the arms, the box and the person at given instants, rendered, in a strip
    mesh_triangles  a real mesh as triangles, for stills
    meshcat_scene   start_meshcat, set_scene_camera, write_scene_html
    stage           floor, grid and light of a Meshcat scene
    person_shape    body and legs of the ghost
    band_limits     HandsBand, where the hands' band lets each hand be
    skeleton_drawer SkeletonGhost (draws), SkeletonDrawer (a LeafSystem that draws what its input ports say)

Nothing is imported here, so that figures need no Drake and the scene needs no matplotlib.
"""
