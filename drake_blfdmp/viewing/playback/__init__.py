"""Playback of MCAP recordings in Meshcat: no plant, no scenario, no Drake; everything comes from the file.

    chunks      an MCAP file record by record
    layouts     where the numbers of a message stand
    sampling    a topic's messages brought to the frame times
    topics      which topics are read, and at which times
    reading     read_played: a file as what is drawn
    poses, frames, urdf, kinematics    where links are
    meshes      a URDF's meshes, where they can be reached
    scene       Scene: Meshcat's objects, and what moves them
    animation   what changes, as Meshcat's animation
    robots, skeleton, forces, surroundings    what is drawn, and from where it is seen
    bounds      the box around it
    page, control_bar    the page and its bar: play, seek, speed, events
    player      make_sheet: files in, a sheet out, which page, server and video take
    server      the page on this machine alone
    video       the page as MP4 or GIF

Imported here and below are mcap, NumPy and meshcat alone; of this package what keeps to that.
"""
