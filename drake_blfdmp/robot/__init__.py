"""The arms, the box and the tables in Drake, and the way from the person's motion to the arms'.

models: where the model files are. plant: both arms, their joint PD and limits. box: the box and its tables. contact:
the contact model, palm forces, how deep to squeeze. contact_wrenches: contact as a wrench at an origin. grasp_force:
the least squeeze that holds, the largest that the joints allow. held_box: what palms and motors bear of a box along a
way, without simulation. clearance: the least distance between what must not touch. kinematics, swivel: palm poses,
Jacobians, the swivel angle. retargeting, reach, reach_evaluation: from the person to palms, where and how large the
motion fits the arms, and how well they follow. led_reach, elbow_paths, swings, closed_form_ik: the same with elbows
that are led around each other. redundancy: what fills the null space. differential_ik, tracking, posture: from palms to
joints; braking, nearest_velocity, pair_clearance, tempo: within the joints' limits, apart, and in time. description:
the whole scene as one URDF. box_look, meshes: what box and arms look like.
"""
