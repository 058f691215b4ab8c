"""ROS 2 messages without ROS: below everything that reads or writes them.

skeleton_markers  the person's points and links as markers
messages   definitions and templates of the messages this package writes
cdr        the bytes of a message
"""
