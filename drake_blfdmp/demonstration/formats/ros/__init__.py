"""ROS 1 and ROS 2 bags, MCAP: markers, transforms, and what runs of this package write."""
