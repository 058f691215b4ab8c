"""What a person sees of a run or a study: figures, stills, and the live or recorded Meshcat scene.

    style           palette, sizes and the axes' common dress
    law_style       one look for every law
    figures         write_figures: every figure of one run
    skill_figures   link lengths, hands' distance, paths
    robot_figures   joint angles, contact forces, the box, swivel angles
    study_figures   a package: the drawings of the studies
    rendering       triangles, a camera and pictures of them, without a GPU
    stills          the person at given instants, and pictures in a strip
    solids          bodies and their poses as plain data, and the triangles of these
    planned_scene   the arms and the box of a plan as solids
    mesh_triangles  a real mesh as triangles, for stills
    drawing         Drawing: a figure before it is drawn, kept in a recording
    redrawing       redraw_study: the figures of a study from its file alone
    meshcat_scene   start_meshcat, set_scene_camera, write_scene_html
    looks           colours, legend and camera of every scene
    stage           floor, grid and light of a Meshcat scene
    person_shape    body and legs of the ghost
    band_limits     HandsBand, where the hands' band lets each hand be
    playback        a package: recordings played back without Drake
    skeleton_drawer SkeletonGhost (draws), SkeletonDrawer (a LeafSystem that draws what its input ports say)

Nothing is imported here, so that figures need no Drake and the scene needs no matplotlib.
"""
